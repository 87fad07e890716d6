"""Boxes lying almost flat, edge over edge: the crossing came again among the corners of the faces."""

import numpy as np

from rb_physics import _core as core
from tests.collision import test_pair_fuzz as fuzz


def test_every_feature_once():
    for seed in (1166, 3787):
        fuzz.check_pair(("box", "box"), seed)


def test_slabs_almost_flat_on_each_other():
    rng = np.random.default_rng(7)
    several = 0
    for _ in range(500):
        a, b = core.Box((0.5, 0.4, 0.1)), core.Box((0.4, 0.5, 0.1))
        q = np.array((*(10.0 ** rng.uniform(-6, -1.5) * rng.normal(size=3)), 1.0))
        at = (rng.uniform(0.6, 0.9), rng.uniform(-0.4, 0.4), 0.2 - 10.0 ** rng.uniform(-6, -2))
        level = (0, 0, 0, 1)
        found = core.find_contacts(a, at, q / np.linalg.norm(q), b, (0, 0, 0), level, 0.05)
        features = found["feature"].tolist()
        assert len(set(features)) == len(features)
        several += len(features) > 1
    assert several > 100
