"""Hulls that touch along a side: EPA found no polytope, and the depth along another face was taken."""

import numpy as np
import pytest

from rb_physics import _core as core

TOP = np.array([(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)])


def prism(corners) -> core.ConvexHull:
    return core.ConvexHull(np.vstack([corners, np.subtract(corners, (0, 0, 0.014455645469020542))]))


def test_the_pair_that_was_found():
    a = prism(
        [
            (-0.004136237339538274, -0.10323294039593922, 0.0),
            (-0.0053954976862695585, -0.08425100340773521, 0.0),
            (-0.023458282939482798, -0.08034479735588067, 0.0),
        ]
    )
    b = prism(
        [
            (-0.031725985216014434, -0.1048488148023543, 0.0),
            (-0.004136237339538274, -0.10323294039593922, 0.0),
            (-0.023458282939482798, -0.08034479735588067, 0.0),
        ]
    )
    h = float.fromhex
    turned_a = (h("0x1.3af65e3541dep-58"), -h("0x1.2be8b6f4f3a14p-64"), -h("0x1.3638fb552f2fdp-60"))
    turned_b = (h("0x1.71ee325d2ad5fp-58"), h("0x1.79dae4b5edae3p-58"), -h("0x1.19f46eac8dbbep-61"))
    at = (0, 0, 2.0**-60)
    found = core.distance(a, at, (*turned_a, 1), b, at, (*turned_b, 1))
    assert found[0] == pytest.approx(0.0, abs=1e-15)  # they share a side, to rounding


def test_pairs_turned_by_rounding():
    for seed in range(3000):
        rng = np.random.default_rng(seed)
        apex = rng.uniform(0.05, 1, 2) * (1, -1)
        a, b = (
            core.ConvexHull(np.vstack([corners, np.subtract(corners, (0, 0, rng.uniform(0.1, 2)))]))
            for corners in (
                np.vstack([TOP, (rng.uniform(-1, 1), apex[0], 0)]),
                np.vstack([TOP, (rng.uniform(-1, 1), apex[1], 0)]),
            )
        )
        turns = [np.append(rng.normal(size=3) * 10.0 ** rng.uniform(-19, -14), 1) for _ in "ab"]
        d = core.distance(a, (0, 0, 0), turns[0], b, (0, 0, 0), turns[1])[0]
        assert d == pytest.approx(0.0, abs=1e-13), seed  # arms of about 1 m times the turn
