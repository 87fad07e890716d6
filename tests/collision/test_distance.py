"""Distance and penetration against proofs: support functions, brute-force axes, another library."""

import itertools

import numpy as np
import pytest

from rb_physics import _core as core
from tests import oracles

RNG = np.random.default_rng(1)
HULL = core.ConvexHull(RNG.normal(size=(30, 3)) * (0.3, 0.2, 0.25))
TETRAHEDRON = core.ConvexHull([(0, 0, 0), (0.5, 0, 0), (0, 0.4, 0), (0, 0, 0.6)])
POLYTOPES = {"box": core.Box((0.2, 0.3, 0.4)), "hull": HULL, "tetrahedron": TETRAHEDRON}
SHAPES = {"particle": core.Particle(), "sphere": core.Sphere(0.3), **POLYTOPES}
PAIRS = list(itertools.combinations_with_replacement(SHAPES, 2))
POLYTOPE_PAIRS = list(itertools.combinations_with_replacement(POLYTOPES, 2))

# Positions and lengths are about 1 m: answers are good to 1e-9 of that, certificates to rounding.
ACCURACY = 1e-9


def poses(seed: int, spread: float):
    rng = np.random.default_rng(seed)
    return [(rng.uniform(-spread, spread, 3), oracles.random_orientation(rng)) for _ in range(2)]


def certify(a, pose_a, b, pose_b):
    """The result proves itself: its points lie on the shapes, and no axis separates them better."""
    d, on_a, on_b, normal = core.distance(a, *pose_a, b, *pose_b)
    assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-14)  # rounding
    assert normal @ (on_a - on_b) == pytest.approx(d, abs=1e-13)  # rounding
    assert oracles.outside(a, pose_a, on_a) <= 1e-13  # rounding
    assert oracles.outside(b, pose_b, on_b) <= 1e-13
    assert oracles.separation_along(a, pose_a, b, pose_b, normal) == pytest.approx(d, abs=ACCURACY)
    if d > 0:
        assert np.linalg.norm(on_a - on_b) == pytest.approx(d, abs=ACCURACY)
    return d


def check_pose(names, seed):
    a, b = (SHAPES[name] for name in names)
    for spread in (0.02, 0.2, 0.6):
        pose_a, pose_b = poses(seed, spread)
        d = certify(a, pose_a, b, pose_b)
        assert core.test_intersection(a, *pose_a, b, *pose_b) == (d <= 0)
        if names[0] in POLYTOPES and names[1] in POLYTOPES:
            brute = oracles.brute_force_separation(a, pose_a, b, pose_b)
            if brute <= 0:
                assert d == pytest.approx(brute, abs=ACCURACY)
            else:
                assert d >= brute - ACCURACY


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_random_poses(names):
    for seed in range(60):
        check_pose(names, seed)


@pytest.mark.soak
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_a_hundred_thousand_random_poses(names):
    for seed in range(33_334):
        check_pose(names, seed)
