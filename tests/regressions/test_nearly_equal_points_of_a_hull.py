"""Hulls with nearly equal points were metres wrong: an edge between them has no direction."""

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core as core


def unit_quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


@pytest.mark.parametrize("apart", [1e-15, 1e-12, 1e-10, 1e-9, 1e-8, 3e-8, 1e-7])
def test_distance_is_that_of_the_hull_without_them(apart):
    for seed in range(200):
        rng = np.random.default_rng(seed)
        points = rng.normal(size=(rng.integers(4, 15), 3))
        noisy = points + apart * rng.normal(size=points.shape)
        plain, doubled = rb.ConvexHull(points), rb.ConvexHull(np.vstack([points, noisy]))
        other = rb.ConvexHull(rng.normal(size=(8, 3)))
        pose = (1.5 * rng.normal(size=3), unit_quaternion(rng), other, (0, 0, 0))
        turn = unit_quaternion(rng)
        expected = core.distance(plain, *pose, turn)[0]
        # No corner is farther from the plain hull than four standard deviations in three axes.
        tolerance = 1e-12 + 4 * np.sqrt(3) * apart
        assert core.distance(doubled, *pose, turn)[0] == pytest.approx(expected, abs=tolerance)


def test_the_first_of_them_is_the_corner_and_the_order_stays():
    cube = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    points = np.vstack([cube, cube[::-1] + 1e-9])
    np.testing.assert_array_equal(rb.ConvexHull(points).points, cube)


def test_a_fine_grid_of_points_takes_no_time():
    side = np.linspace(-1, 1, 50)
    x, y = np.meshgrid(side, side)
    sheets = [np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)]) for z in (0.0, 1.0)]
    assert len(rb.ConvexHull(np.vstack(sheets)).points) == 8
