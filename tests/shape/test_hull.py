"""Convex hulls: which corners, faces and edges come out, what is refused, and how much they weigh."""

import pickle

import numpy as np
import pytest

import rb_physics.errors
from rb_physics import _core as core

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


def test_cube_from_a_grid_has_six_square_faces():
    axis = np.linspace(-1, 1, 5)
    grid = np.array(np.meshgrid(axis, axis, axis)).reshape(3, -1).T
    hull = core.ConvexHull(np.vstack([grid, grid]))
    assert sorted(map(tuple, hull.points.tolist())) == sorted(map(tuple, CUBE.tolist()))
    assert [len(face) for face in hull.faces] == [4] * 6
    assert len(hull.edges) == 12


@pytest.mark.parametrize("seed", range(20))
def test_turned_and_noisy_cube_still_has_square_faces(seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    axis = np.linspace(-1, 1, 4)
    grid = np.array(np.meshgrid(axis, axis, axis)).reshape(3, -1).T @ turn.T
    hull = core.ConvexHull(grid + rng.uniform(-1e-15, 1e-15, grid.shape))
    assert [len(face) for face in hull.faces] == [4] * 6
    assert len(hull.points) == 8


@pytest.mark.parametrize("seed", range(20))
def test_hull_holds_every_point_and_its_corners_are_extreme(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(400, 3)) * 10.0 ** rng.uniform(-2, 2, 3)
    size = np.abs(points).max()
    hull = core.ConvexHull(points)
    corners = hull.points
    for face in hull.faces:
        p = corners[face]
        normal = np.cross(p[1] - p[0], p[2] - p[0])
        normal /= np.linalg.norm(normal)
        # Faces are flat and hold all points to 1e-10 of the extent, the tolerance of merging.
        assert (points @ normal).max() <= (p @ normal).min() + 4e-10 * size
    assert len(corners) - len(hull.edges) + len(hull.faces) == 2


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (CUBE[:3], "at least 4 points"),
        (np.zeros((8, 3)), "coincide"),
        (np.outer(np.arange(8), (1, 2, 3)), "lie on a line"),
        (CUBE * (1, 1, 0), "lie in a plane"),
        (CUBE * (1, 1, 1e-7), "lie in a plane"),
        ([*CUBE, (np.nan, 0, 0)], "finite"),
        (CUBE.ravel(), "shape"),
    ],
)
def test_what_spans_no_volume_is_refused(points, message):
    with pytest.raises(rb_physics.errors.SceneError, match=message):
        core.ConvexHull(points)


def test_pickle_keeps_every_bit():
    hull = core.ConvexHull(np.random.default_rng(0).normal(size=(50, 3)))
    copy = pickle.loads(pickle.dumps(hull))
    assert copy == hull
    assert copy.faces == hull.faces
