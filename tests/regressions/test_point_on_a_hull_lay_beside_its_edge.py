"""Over an edge of a hull, a hair outside of a face, the point of a ball's contact lay beside the face."""

import numpy as np

from rb_physics import _core as core
from tests import oracles

TETRAHEDRON = core.ConvexHull([(0, 0, 0), (0.5, 0, 0), (0, 0.4, 0), (0, 0, 0.6)])
IDENTITY = (0.0, 0.0, 0.0, 1.0)


def test_the_point_is_the_nearest():
    rng = np.random.default_rng(0)
    at = (np.zeros(3), IDENTITY)
    for beside in 10.0 ** rng.uniform(-12, -4, 200):
        # Below the edge along y of the face x = 0 and the face z = 0.
        y, height = rng.uniform(0.05, 0.35), rng.uniform(0.05, 0.4)
        center = np.array((-beside, y, -height))
        found = core.find_contacts(core.Sphere(0.3), center, IDENTITY, TETRAHEDRON, *at, 1.0)
        assert len(found["separation"]) == 1
        assert oracles.outside(TETRAHEDRON, at, found["point_b"][0]) <= 1e-15  # rounding
        assert np.abs(found["point_b"][0] - (0, y, 0)).max() <= 1e-14
        away = (center - (0, y, 0)) / np.hypot(beside, height)
        assert np.abs(found["normal"][0] - away).max() <= 1e-14
