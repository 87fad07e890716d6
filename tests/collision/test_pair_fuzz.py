"""Every pair of shapes under hard poses: sizes 1e-4 to 1e3 m, ratios to 1e4, touching, far away.

Whatever comes in, the answer is finite, has unit normals, separates, and mirrors when A and B change
places.
"""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rb_physics import _core as core
from tests import oracles

NAMES = ["particle", "sphere", "capsule", "cylinder", "box", "hull"]
PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))


def make(name: str, size: float, rng: np.random.Generator):
    """A shape of about `size` m, up to 10 times slimmer in some directions."""
    a, b, c = size * 10.0 ** rng.uniform(-1, 0, 3)
    if name == "particle":
        return core.Particle()
    if name == "sphere":
        return core.Sphere(a)
    if name == "capsule":
        return core.Capsule(a, b)
    if name == "cylinder":
        return core.Cylinder(a, b)
    if name == "box":
        return core.Box((a, b, c))
    points = rng.normal(size=(rng.integers(5, 40), 3))
    return core.ConvexHull(np.vstack([points, -points]) * (a, b, c))


def orientation(rng: np.random.Generator) -> np.ndarray:
    """Random, or aligned with the axes as resting bodies are, or nearly so."""
    kind = rng.integers(4)
    if kind == 0:
        return oracles.random_orientation(rng)
    q = np.zeros(4)
    q[rng.integers(4)] = 1.0
    if kind == 1:
        q = np.array([0.5, 0.5, 0.5, 0.5]) * rng.choice([-1, 1], 4)
    if kind == 2:
        q = q + 10.0 ** rng.uniform(-16, -3) * rng.normal(size=4)
    return q / np.linalg.norm(q)


def check_contacts(a, pose_a, b, pose_b, margin, scale):
    there = core.find_contacts(a, *pose_a, b, *pose_b, margin)
    back = core.find_contacts(b, *pose_b, a, *pose_a, margin)
    assert all(np.isfinite(values).all() for values in there.values())
    assert len(there["kind"]) <= 8
    assert len(set(there["feature"].tolist())) == len(there["feature"])
    for i in range(len(there["kind"])):
        n = there["normal"][i]
        assert np.linalg.norm(n) == pytest.approx(1, abs=1e-14)  # rounding
        apart = n @ (there["point_a"][i] - there["point_b"][i])
        assert apart == pytest.approx(there["separation"][i], abs=1e-13 * scale), (a, b)
        assert there["separation"][i] <= margin
    assert (there["normal"] == -back["normal"]).all()
    assert (there["separation"] == back["separation"]).all()
    assert (there["point_a"] == back["point_b"]).all()
    assert (there["point_b"] == back["point_a"]).all()
    assert (there["feature"] >> 31 == back["feature"] & (2**31 - 1)).all()
    return there


def check_pair(names, seed):
    rng = np.random.default_rng(seed)
    size_a = 10.0 ** rng.uniform(-4, 3)
    size_b = size_a * 10.0 ** rng.uniform(-4, 4)
    size_b = min(max(size_b, 1e-4), 1e3)
    a, b = make(names[0], size_a, rng), make(names[1], size_b, rng)
    # Lengths of the pair; a particle has none of its own.
    small = min(size_a, size_b) if names[0] != "particle" else size_b
    scale = size_a + size_b
    pose_a = (rng.uniform(-1, 1, 3) * (size_a + size_b), orientation(rng))
    pose_b = (np.zeros(3), orientation(rng))
    d, _, _, n = core.distance(a, *pose_a, b, *pose_b)
    # 1e-9 of the smaller shape, as far as the larger one's coordinates can be told apart.
    accuracy = 1e-9 * small + 4e-12 * scale
    assert oracles.separation_along(a, pose_a, b, pose_b, n) == pytest.approx(d, abs=accuracy)
    check_contacts(a, pose_a, b, pose_b, 0.1 * scale, scale)

    # Brought into touch along the normal found, then slightly deeper and slightly apart.
    for gap in (0.0, -1e-9 * small, 1e-9 * small, -1e-3 * small, 1e-3 * small):
        near = (pose_a[0] - (d - gap) * n, pose_a[1])
        again = core.distance(a, *near, b, *pose_b)[0]
        assert again >= gap - accuracy, (names, seed)
        if d > 0 and gap >= 0:
            # A direction is good to 1e-7 where features nearly tie: the way along it ends that far aside.
            assert again <= gap + accuracy + 1e-7 * small, (names, seed)
        # Two particles in one pose have nothing that tells A from B.
        if names != ("particle", "particle"):
            check_contacts(a, near, b, pose_b, 2e-3 * small, scale)

    # Concentric.
    if names != ("particle", "particle"):
        check_contacts(a, (np.zeros(3), pose_a[1]), b, pose_b, 0.0, scale)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_pairs(names):
    for seed in range(40):
        check_pair(names, seed)


@pytest.mark.soak
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_many_pairs(names):
    for seed in range(1000, 21_000):
        check_pair(names, seed)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(names=st.sampled_from(PAIRS), seed=st.integers(0, 2**63))
def test_any_pair(names, seed):
    check_pair(names, seed)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_far_from_the_origin_the_separation_is_as_exact(names):
    rng = np.random.default_rng(3)
    a, b = make(names[0], 1.0, rng), make(names[1], 1.0, rng)
    # Multiples of 2^-20 add exactly to 2^20, so both pairs are in the same relative position.
    step = rng.integers(-(2**19), 2**19, 3) * 2.0**-20
    qa, qb = oracles.random_orientation(rng), oracles.random_orientation(rng)
    near = core.find_contacts(a, step, qa, b, (0, 0, 0), qb, 1.0)
    far = core.find_contacts(a, step + 2.0**20, qa, b, np.full(3, 2.0**20), qb, 1.0)
    assert (near["separation"] == far["separation"]).all()
    assert (near["normal"] == far["normal"]).all()


@pytest.mark.parametrize("name", [n for n in NAMES if n != "particle"])
def test_half_space(name):
    for seed in range(60):
        rng = np.random.default_rng(seed)
        a = make(name, 10.0 ** rng.uniform(-4, 3), rng)
        scale = core.bounding_radius(a, (0, 0, 0))
        normal = rng.normal(size=3)
        plane = core.HalfSpace(normal / np.linalg.norm(normal), scale * rng.uniform(-1, 1))
        pose_a = (rng.uniform(-1, 1, 3) * scale, orientation(rng))
        pose_b = (rng.uniform(-1, 1, 3) * scale, orientation(rng))
        n = oracles.rotation(pose_b[1]) @ plane.normal
        lowest = -oracles.reach(a, pose_a, -n) - n @ pose_b[0] - plane.offset
        assert core.distance(a, *pose_a, plane, *pose_b)[0] == pytest.approx(
            lowest, abs=1e-14 * scale
        )
        found = check_contacts(a, pose_a, plane, pose_b, 2 * scale, 4 * scale)
        for p, q in zip(found["point_a"], found["point_b"], strict=True):
            assert oracles.outside(a, pose_a, p) <= 1e-14 * scale
            assert oracles.outside(plane, pose_b, q) <= 4e-15 * scale
