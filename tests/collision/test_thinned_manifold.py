"""More than eight corners: the eight that are kept lie as symmetrically as the corners did."""

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core as core

IDENTITY = (0.0, 0.0, 0.0, 1.0)
PLANE = core.HalfSpace((0, 0, 1), 0.0)
PLATE = core.Box((2, 2, 0.5))


def prism(corners: int) -> core.ConvexHull:
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    return core.ConvexHull([(x, y, z) for x, y in ring for z in (-0.5, 0.5)])


def kept(corners: int, ground, at) -> np.ndarray:
    found = core.find_contacts(prism(corners), (0, 0, 0.5), IDENTITY, ground, at, IDENTITY, 1e-6)
    return found["point_b"][:, :2]


@pytest.mark.parametrize("corners", [10, 12, 16, 20, 24, 32, 64])
@pytest.mark.parametrize(("ground", "at"), [(PLANE, (0, 0, 0)), (PLATE, (0, 0, -0.5))])
def test_regular_prism_stands_on_a_symmetric_eight(corners, ground, at):
    points = kept(corners, ground, at)
    assert len(points) == 8
    # Central symmetry: the mean is the centre, and every point has its opposite.
    assert np.abs(points.mean(axis=0)).max() <= 1e-15  # rounding
    apart = np.linalg.norm(points[:, None] + points[None], axis=2)
    assert apart.min(axis=1).max() <= 1e-15


@pytest.mark.parametrize("corners", [12, 16, 24])
def test_the_choice_does_not_change_with_rounding(corners):
    exact = core.find_contacts(
        prism(corners), (0, 0, 0.5), IDENTITY, PLATE, (0, 0, -0.5), IDENTITY, 1e-6
    )
    for seed in range(20):
        noise = np.random.default_rng(seed).uniform(-1e-15, 1e-15, 6)
        near = core.find_contacts(
            prism(corners), (noise[0], noise[1], 0.5 + noise[2]), (*noise[3:6], 1.0),
            PLATE, (0, 0, -0.5), IDENTITY, 1e-6,
        )  # fmt: skip
        assert sorted(near["feature"]) == sorted(exact["feature"])


@pytest.mark.parametrize("corners", [12, 16])
def test_its_weight_is_shared_symmetrically(corners):
    world = rb.World()
    world.add_body(PLANE, type="static", name="ground")
    body = world.add_body(prism(corners), mass=1.0, position=(0, 0, 0.5), name="prism")
    world.step(50)
    force = world.contacts["force"][:, 2]
    assert len(force) == 8
    assert force.sum() == pytest.approx(9.81 * body.mass, abs=1e-12)
    assert np.abs(world.contacts["point"][:, :2].T @ force).max() <= 1e-12  # no moment
