"""Energy of whole worlds, step by step: it rises in none, whatever stage of the step is at work."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import rb_physics as rb

G = 9.81
LAWS = ("sequential", "simultaneous", "reflections")
SHAPES = (
    lambda r: rb.Sphere(r[0]),
    rb.Box,
    lambda r: rb.Capsule(0.5 * r[0], r[1]),
    lambda r: rb.Cylinder(r[0], r[1]),
    lambda r: rb.ConvexHull(np.array([[1, 0, 0], [-1, 1, 0], [-1, -1, 0], [0, 0, 1]]) * r),
)


def crowd(rng, gravity, **settings):
    """Tumbling bodies of all shapes that meet: in free space, or falling onto a floor."""
    size = 10 ** rng.uniform(-2, 1)
    world = rb.World(
        gravity=(0, 0, -gravity),
        dt=rng.choice([1e-3, 2e-3, 5e-3]),
        impact_law=rng.choice(LAWS),
        **settings,
    )
    more = {"friction": rng.choice([0, 0.3, 1, 1.8]), "restitution": rng.choice([0, 0.3, 0.8, 1])}
    if gravity:
        world.add_body(rb.HalfSpace((0, 0, 1), 0), type="static", **more)
    for k in range(int(rng.integers(2, 7))):
        x = 2.5 * size * np.array([np.cos(k), np.sin(k), 0.2 * rng.normal()])
        if gravity:
            x = size * np.array([*rng.uniform(-1, 1, 2), 3 * k + 2])
        q = rng.normal(size=4)
        world.add_body(
            SHAPES[rng.integers(len(SHAPES))](size * rng.uniform(0.3, 1, 3)),
            mass=10 ** rng.uniform(-3, 3),
            position=x,
            orientation=q / np.linalg.norm(q),
            linear_velocity=rng.normal(size=3) * np.sqrt(size) if gravity else -4 * x,
            angular_velocity=rng.normal(size=3) * 10,
            rolling_friction=rng.choice([0, 0.02]) * size,
            **more,
        )
    return world


def rises(world, seconds):
    """What the energy of each step is above that before, J, and the kinetic energy before, J."""
    out = []
    before = world.kinetic_energy + world.potential_energy
    for _ in range(min(250, round(seconds / world.dt))):
        kinetic = world.kinetic_energy
        world.step()
        after = world.kinetic_energy + world.potential_energy
        out.append((after - before, kinetic))
        before = after
    return np.array(out)


def check_free(seed, stepper, max_events):
    """Nothing but contact at work: 1e-12 of the energy before, the project's bound."""
    world = crowd(np.random.default_rng(seed), 0.0, stepper=stepper, max_events=max_events)
    rise, kinetic = rises(world, 0.8).T
    assert (rise <= 1e-12 * kinetic).all(), (seed, (rise / kinetic).max())


def check_falling(seed, stepper, max_events):
    """Motion adds nothing, whether a step meets all its events or is cut short. What has no speed to
    give it from may be lifted out of an overlap: that is of second order in dt, a hundredth of
    g dt^2 at most here, and rare.
    """
    world = crowd(np.random.default_rng(seed), G, stepper=stepper, max_events=max_events)
    height = np.abs(world.positions).max()
    weight = G * sum(b.mass for b in world.bodies if b.type == "dynamic")
    rise, kinetic = rises(world, 1.0).T
    rounding = 1e-12 * (kinetic + weight * height)
    assert (rise <= rounding + 0.01 * weight * G * world.dt**2).all(), (seed, rise.max() / weight)
    assert (rise > rounding).mean() < 0.02, seed


seeds = st.integers(0, 10**6)
steppers = st.sampled_from(["fixed", "event"])
events = st.sampled_from([16, 1])


@given(seeds, steppers, events)
@hypothesis_settings(max_examples=60, deadline=None, derandomize=True)
def test_energy_of_bodies_among_themselves_rises_in_no_step(seed, stepper, max_events):
    check_free(seed, stepper, max_events)


@given(seeds, steppers, events)
@hypothesis_settings(max_examples=60, deadline=None, derandomize=True)
def test_energy_of_bodies_that_fall_rises_in_no_step(seed, stepper, max_events):
    check_falling(seed, stepper, max_events)


@pytest.mark.soak
@pytest.mark.parametrize("check", [check_free, check_falling])
def test_energy_rises_in_no_step_of_many_worlds(check):
    for seed in range(10**7, 10**7 + 2000):
        check(seed, ("fixed", "event")[seed % 2], (16, 1)[seed // 2 % 2])


def test_a_heap_in_free_space_keeps_both_momenta_and_gains_no_energy():
    """More contacts than are solved to the end in a step: what is left open costs energy only."""
    rng = np.random.default_rng(1)
    world = rb.World(gravity=(0, 0, 0), dt=5e-3)
    for k in range(216):
        x = 0.22 * (np.array([k % 6, k // 6 % 6, k // 36]) - 2.5) + rng.normal(size=3) * 0.003
        shape = rb.Box((0.1, 0.1, 0.1)) if rng.random() < 0.7 else rb.Sphere(0.1)
        world.add_body(
            shape, mass=10 ** rng.uniform(-1, 1), position=x, linear_velocity=-2 * x, friction=0.5
        )
    large = 0
    scale = sum(b.mass * np.linalg.norm(b.linear_velocity) for b in world.bodies)  # m of arm
    p, L = world.linear_momentum, world.angular_momentum
    for _ in range(60):
        energy = world.kinetic_energy
        world.step()
        assert world.kinetic_energy <= energy * (1 + 1e-12)
        large += world.stats.contacts > 400
    assert large >= 5
    # Rounding of sixty times a thousand impulses.
    np.testing.assert_allclose(world.linear_momentum, p, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(world.angular_momentum, L, rtol=0, atol=1e-13 * scale)
