"""A cylinder leaning in the plane of a capsule's axis touches it with the point of its rim that lies in
that plane: a summit exactly where two arcs of normals meet, which neither of them claimed. The
answer was the cap's separation, however far that is from the greatest."""

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core as core

UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def _about_y(angle):
    return (0.0, float(np.sin(angle / 2)), 0.0, float(np.cos(angle / 2)))


def _reach(half_length, radius, angle, direction):
    """How far a cylinder, turned about y by the angle, reaches along the directions in the plane y = 0."""
    axis = np.array([np.sin(angle), np.cos(angle)])
    across = np.array([axis[1], -axis[0]])
    return half_length * np.abs(direction @ axis) + radius * np.abs(direction @ across)


def _greatest_separation(reach_a, reach_b, apart):
    """Over all directions of the plane, by ever finer grids."""
    low, high = 0.0, 2 * np.pi
    for _ in range(12):
        turns = np.linspace(low, high, 2001)
        direction = np.column_stack([np.cos(turns), np.sin(turns)])
        separation = direction @ apart - reach_a(direction) - reach_b(-direction)
        best = turns[np.argmax(separation)]
        step = turns[1] - turns[0]
        low, high = best - 2 * step, best + 2 * step
    return separation.max()


def _case(seed, size):
    """Found and expected distance of a capsule and a cylinder that leans toward it."""
    rng = np.random.default_rng(seed)
    radius, half = rng.uniform(0.3, 1, 2) * size
    lean = np.pi / 2 - rng.uniform(-0.9, 0.9) * (1 if seed % 2 else 1e-4)
    wide, long = rng.uniform(0.3, 1, 2) * size * 10 ** rng.uniform(-3, 0)
    apart = np.array(
        [radius + rng.uniform(1.0, 1.3) * (wide + long), rng.uniform(-0.9, 0.9) * half]
    )
    capsule, cylinder = core.Capsule(radius, half), core.Cylinder(wide, long)
    found = core.distance(
        capsule, (0, 0, 0), UPRIGHT, cylinder, (apart[0], 0, apart[1]), _about_y(lean)
    )[0]
    expected = _greatest_separation(
        lambda d: half * np.abs(d[:, 1]) + radius, lambda d: _reach(long, wide, lean, d), apart
    )
    return found, expected


@pytest.mark.parametrize("size", [1e-4, 0.1, 500.0])
def test_capsule_and_a_cylinder_that_leans_toward_it(size):
    for seed in range(200):
        found, expected = _case(seed, size)
        assert found == pytest.approx(expected, abs=1e-9 * size), seed


def test_a_small_cylinder_parts_from_a_capsule_it_is_concentric_with():
    for large, small in ((500.0, 0.1), (0.5, 1e-4), (50.0, 0.1)):
        world = rb.World(gravity=(0, 0, 0), dt=1e-3)
        a = world.add_body(rb.Capsule(large, 1.4 * large), density=1000.0, name="capsule")
        b = world.add_body(rb.Cylinder(0.6 * small, small), density=1000.0, name="cylinder")
        world.step(10)
        assert rb.distance(a, b).distance >= -1e-6 * small
        assert world.kinetic_energy == 0.0
