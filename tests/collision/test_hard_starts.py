"""Bodies that start concentric or deep inside each other, at any size: a finite answer that parts them."""

import itertools

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core as core
from tests import oracles

POINTS = np.random.default_rng(4).normal(size=(12, 3))


def shape(name: str, size: float):
    """A shape of about `size` m."""
    if name == "sphere":
        return core.Sphere(size)
    if name == "box":
        return core.Box((size, 0.7 * size, 0.5 * size))
    if name == "capsule":
        return core.Capsule(0.5 * size, 0.7 * size)
    if name == "cylinder":
        return core.Cylinder(0.6 * size, size)
    return core.ConvexHull(size * np.vstack([POINTS, -POINTS]) / np.abs(POINTS).max())


NAMES = ["sphere", "box", "capsule", "cylinder", "hull"]
PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))


@pytest.mark.parametrize("sizes", [(1, 1), (1e-4, 1e-4), (1e3, 1e3), (1, 1e-4), (1e-1, 1e3)])
@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_moving_out_along_the_normal_parts_them(names, sizes):
    a, b = (shape(n, s) for n, s in zip(names, sizes, strict=True))
    small, large = min(sizes), max(sizes)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        qa = qb = np.array([0.0, 0.0, 0.0, 1.0])
        if seed % 3:
            qa, qb = (oracles.random_orientation(rng) for _ in range(2))
        offset = np.zeros(3) if seed < 4 else rng.uniform(-0.2, 0.2, 3) * small
        d, on_a, on_b, n = core.distance(a, offset, qa, b, (0, 0, 0), qb)
        assert np.isfinite([d, *on_a, *on_b, *n]).all()
        assert d < 0
        assert np.linalg.norm(n) == pytest.approx(1, abs=1e-14)  # rounding
        # 1e-9 of the smaller one, as far as coordinates of the larger one can be told apart.
        accuracy = 1e-9 * small + 1e-14 * large
        parted = core.distance(a, offset - d * n, qa, b, (0, 0, 0), qb)[0]
        assert parted >= -accuracy
        contacts = core.find_contacts(a, offset, qa, b, (0, 0, 0), qb, 0.0)
        assert 1 <= len(contacts["kind"]) <= 8
        assert contacts["separation"].min() == pytest.approx(d, abs=accuracy)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_concentric_bodies_come_apart_in_the_simulation(names):
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    a = world.add_body(shape(names[0], 0.1), mass=1.0, name="a")
    b = world.add_body(shape(names[1], 0.1), mass=1.0, name="b")
    before = rb.distance(a, b).distance
    for _ in range(50):
        world.step(20)
        assert np.isfinite(world.positions).all()
        assert np.isfinite(world.orientations).all()
    after = rb.distance(a, b).distance
    assert before < 0
    # Out to the slop that position correction leaves, and gently: no energy comes from it.
    assert after > 0.1 * before
    assert world.kinetic_energy <= 1e-12
