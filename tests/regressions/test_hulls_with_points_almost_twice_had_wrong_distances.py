"""Points 1e-13 to 1e-6 of the size apart leave sliver faces, whose normals are rounding."""

import itertools

import numpy as np
import pytest

from rb_physics import _core as core
from tests import oracles

GRID = np.array(list(itertools.product((-1, 0, 1), repeat=3)), float)


def noisy_hull(rng, noise):
    kind = rng.integers(3)
    if kind == 0:
        points = np.repeat(rng.normal(size=(rng.integers(4, 15), 3)), 2, axis=0)
    elif kind == 1:
        points = GRID
    else:
        angles = np.arange(12) * np.pi / 6
        points = np.vstack(
            [np.c_[np.cos(angles), np.sin(angles), np.full(12, z)] for z in (-0.3, 0.3)]
        )
    return core.ConvexHull(points + noise * rng.normal(size=points.shape))


def check(seed):
    rng = np.random.default_rng(seed)
    noise = 10.0 ** rng.uniform(-13, -5)
    try:
        a, b = noisy_hull(rng, noise), noisy_hull(rng, noise)
    except ValueError:  # says what to do about the points
        return 0
    away = rng.normal(size=3)
    turns = [oracles.random_orientation(rng) if rng.integers(2) else (0, 0, 0, 1) for _ in "ab"]
    pose_a = (away / np.linalg.norm(away) * rng.uniform(0.3, 2.6), turns[0])
    pose_b = (np.zeros(3), turns[1])
    for _ in range(2):
        d, on_a, on_b, n = core.distance(a, *pose_a, b, *pose_b)
        # 1e-9 of sizes of 2.
        assert oracles.separation_along(a, pose_a, b, pose_b, n) == pytest.approx(d, abs=4e-9), seed
        assert n @ (on_a - on_b) == pytest.approx(d, abs=4e-9)
        found = core.find_contacts(a, *pose_a, b, *pose_b, max(d, 0) + 1e-3)
        assert len(found["separation"]) > 0, seed
        assert found["separation"].min() == pytest.approx(d, abs=4e-9), seed
        pose_a = (pose_a[0] - (d + rng.choice([0, 1e-9, 1e-4])) * n, pose_a[1])
    return 1


def test_distances_are_those_along_their_normals():
    assert sum(check(seed) for seed in range(600)) > 400


@pytest.mark.soak
def test_many_distances():
    assert sum(check(seed) for seed in range(1000, 21_000)) > 10_000
