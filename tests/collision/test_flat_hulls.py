"""Hulls that lie nearly flat on each other, edge over edge, have the corners of their facing faces as
boxes have: a little turn brings them down."""

import numpy as np

import rb_physics as rb
from rb_physics import _core as core

HALF = np.array([0.1, 0.15, 0.08])
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


def _rows(found):
    table = np.hstack([found["point_a"], found["point_b"], found["separation"][:, None]])
    return np.array(sorted(map(tuple, np.round(table, 9))))


def test_boxes_given_by_their_corners_have_the_contacts_of_boxes():
    box, hull = core.Box(HALF), core.ConvexHull(HALF * CORNERS)
    crossings = 0
    for seed in range(600):
        rng = np.random.default_rng(seed)
        yaw, lean = rng.uniform(0, 2 * np.pi), rng.uniform(-0.03, 0.03, 2)
        turn = np.array([*lean, np.sin(yaw / 2), np.cos(yaw / 2)])
        place = (*rng.uniform(-0.15, 0.15, 2), 0.158 + rng.uniform(-0.004, 0.006))
        pose, level = (place, turn / np.linalg.norm(turn)), ((0, 0, 0), (0, 0, 0, 1))
        expected = _rows(core.find_contacts(box, *pose, box, *level, 0.01))
        for a, b in ((hull, hull), (box, hull), (hull, box)):
            found = core.find_contacts(a, *pose, b, *level, 0.01)
            rows = _rows(found)
            assert rows.shape == expected.shape, seed
            np.testing.assert_allclose(rows, expected, rtol=0, atol=2e-9)
            features = found["feature"].tolist()
            assert len(set(features)) == len(features)
        kinds = core.find_contacts(hull, *pose, hull, *level, 0.01)["kind"]
        crossings += int(rb.ContactKind.EDGE_EDGE) in kinds.astype(int) and len(kinds) > 1
    assert crossings > 50
