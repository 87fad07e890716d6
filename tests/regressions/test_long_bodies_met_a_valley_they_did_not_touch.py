"""A point far outside of a surface, behind both faces of a valley, counted as over both of them."""

import numpy as np
import pytest

from rb_physics import _core as core
from tests import oracles

VALLEY_MESH = core.TriangleMesh(
    [(-1, -1, 0.7), (0, -1, 0), (1, -1, 0.7), (-1, 1, 0.7), (0, 1, 0), (1, 1, 0.7)],
    [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)],
)
VALLEY_FIELD = core.HeightField(np.array([(0.7, 0.7), (0, 0), (0.7, 0.7)]), (1.0, 2.0))
SURFACES = {"mesh": (VALLEY_MESH, (0, 0, 0)), "height field": (VALLEY_FIELD, (-1, -1, 0))}
BODIES = {
    "bar": core.Box((1.5, 0.05, 0.05)),
    "plate": core.Box((1, 1, 0.05)),
    "box": core.Box((0.1, 0.15, 0.1)),
    "rod": core.Capsule(0.05, 1.5),
    "cylinder": core.Cylinder(0.05, 1.5),
}


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("surface", SURFACES)
def test_no_contacts_without_touch(surface, body):
    rng = np.random.default_rng(0)
    shape, (floor, at) = BODIES[body], SURFACES[surface]
    apart = 0
    for _ in range(2000):
        pose = (
            rng.uniform(-1, 1, 3) * (1.5, 0.8, 1) + (0, 0, 0.8),
            oracles.random_orientation(rng),
        )
        distance = core.distance(shape, *pose, floor, at, (0, 0, 0, 1))[0]
        if distance <= 1e-9:
            continue
        apart += 1
        found = core.find_contacts(shape, *pose, floor, at, (0, 0, 0, 1), 0.0)
        assert len(found["separation"]) == 0, pose
    assert apart > 200
