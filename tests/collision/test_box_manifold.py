"""Manifolds of boxes on planes and on boxes: where, how many, of which kind, under which ids."""

import numpy as np
import pytest

from rb_physics import _core as core

IDENTITY = (0.0, 0.0, 0.0, 1.0)
PLANE = core.HalfSpace((0.0, 0.0, 1.0), 0.0)
VERTEX_FACE, EDGE_EDGE, EDGE_FACE, FACE_FACE, SMOOTH = range(5)


def about(axis: tuple[float, float, float], angle: float) -> np.ndarray:
    """Quaternion (x, y, z, w) of a turn by `angle` about `axis`."""
    n = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.append(np.sin(angle / 2) * n, np.cos(angle / 2))


def find(a, pose_a, b, pose_b, margin=1e-6):
    return core.find_contacts(a, *pose_a, b, *pose_b, margin)


def test_box_on_plane_rests_on_its_four_corners():
    box = core.Box((0.1, 0.2, 0.3))
    found = find(box, ((0, 0, 0.3), IDENTITY), PLANE, ((0, 0, 0), IDENTITY))
    assert found["separation"].tolist() == [0.0] * 4
    assert found["kind"].tolist() == [FACE_FACE] * 4
    corners = {tuple(p) for p in found["point_a"].tolist()}
    assert corners == {(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.2, 0.2)}


def test_box_on_edge_and_on_corner():
    box = core.Box((0.1, 0.1, 0.1))
    edge = find(
        box, ((0, 0, 0.1 * 2**0.5), about((1, 0, 0), np.pi / 4)), PLANE, ((0, 0, 0), IDENTITY)
    )
    assert edge["kind"].tolist() == [EDGE_FACE] * 2
    corner_down = about(np.cross((1, 1, 1), (0, 0, -1)), np.arccos(-1 / 3**0.5))
    corner = find(box, ((0, 0, 0.1 * 3**0.5), corner_down), PLANE, ((0, 0, 0), IDENTITY))
    assert corner["kind"].tolist() == [VERTEX_FACE]


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.05, 0.0), (0.05, 0.03), (0.2, 0.0)])
@pytest.mark.parametrize("noise", [0.0, 1e-16, -1e-16])
def test_stacked_boxes_keep_ids_whatever_rounding_does(offset, noise):
    box = core.Box((0.1, 0.1, 0.1))
    lower = ((0.0, 0.0, 0.1), IDENTITY)
    exact = find(box, ((*offset, 0.3), IDENTITY), box, lower)
    tilted = about((0.3, 1, 0.2), 4 * noise)
    near = find(box, ((offset[0] + noise, offset[1] - noise, 0.3 + noise), tilted), box, lower)
    assert near["feature"].tolist() == exact["feature"].tolist()
    assert exact["kind"].tolist() == [FACE_FACE] * len(exact["kind"])
    x, y = exact["point_a"][:, 0], exact["point_a"][:, 1]
    assert (x.min(), x.max()) == pytest.approx((offset[0] - 0.1, 0.1), abs=1e-15)  # rounding
    assert (y.min(), y.max()) == pytest.approx((offset[1] - 0.1, 0.1), abs=1e-15)


def test_crossed_edges_touch_in_one_point():
    box = core.Box((0.1, 0.1, 0.1))
    lower = about((1, 0, 0), np.pi / 4)  # an edge along x on top
    upper = about((0, 1, 0), np.pi / 4)  # an edge along y below
    found = find(box, ((0, 0, 0.2 * 2**0.5), upper), box, ((0, 0, 0), lower))
    assert found["kind"].tolist() == [EDGE_EDGE]
    assert found["normal"][0] == pytest.approx((0, 0, 1), abs=1e-15)  # rounding
    assert found["separation"][0] == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize("seed", range(50))
def test_exchanging_the_bodies_mirrors_every_bit(seed):
    rng = np.random.default_rng(seed)
    shapes = [core.Sphere(0.2), core.Box((0.1, 0.2, 0.3)), core.Box((0.1, 0.2, 0.3)), PLANE]
    for a in shapes:
        for b in shapes:
            if a is PLANE and b is PLANE:
                continue
            q = rng.normal(size=(2, 4))
            q /= np.linalg.norm(q, axis=1)[:, None]
            p = rng.uniform(-0.2, 0.2, size=(2, 3))
            there = find(a, (p[0], q[0]), b, (p[1], q[1]), margin=0.05)
            back = find(b, (p[1], q[1]), a, (p[0], q[0]), margin=0.05)
            assert (there["separation"] == back["separation"]).all()
            assert (there["normal"] == -back["normal"]).all()
            assert (there["point_a"] == back["point_b"]).all()
            assert (there["feature"] >> 31 == back["feature"] & (2**31 - 1)).all()
