"""A small body that leaves a wall spinning at 1e5 rad/s made each later step take seconds, and no
statistic told: every look at its attitude worked out all its turns since the step began."""

import time

import pytest

import rb_physics as rb

# s per step on a slow machine; it is below 0.02 s, it was 2 to 10 s.
STEP = 0.5


def worlds(shape, spin, velocity, stepper):
    world = rb.World(dt=5e-3, gravity=(0, 0, -9.81), stepper=stepper)
    world.add_body(rb.Box((0.0005, 1, 1)), type="static", name="wall")
    bullet = world.add_body(
        shape,
        mass=0.01,
        name="bullet",
        position=(-0.00122, 0.0, 0.0),
        linear_velocity=velocity,
        angular_velocity=spin,
        restitution=1.0,
    )
    return world, bullet


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("velocity", [(-0.06, -2.7, -9.5), (-50.0, 0.0, 0.0)])
@pytest.mark.parametrize(
    "shape",
    [rb.Box((7e-5, 7e-5, 6e-4)), rb.Capsule(2e-4, 4e-4), rb.Cylinder(5e-4, 1e-4)],
    ids=lambda shape: type(shape).__name__,
)
def test_steps_of_a_spinning_bullet_stay_short(shape, velocity, stepper):
    world, bullet = worlds(shape, (4.6e4, -4.2e4, -7.6e4), velocity, stepper)
    for _ in range(5):
        begin = time.perf_counter()
        world.step()
        assert time.perf_counter() - begin < STEP
        assert bullet.position[0] < -0.0005  # on its side of the wall


def test_capsule_that_spins_about_its_axis_along_a_wall():
    """Hardly off the wall and turning about its own axis, it comes no nearer: nothing to look for."""
    world = rb.World(dt=5e-3, gravity=(0, 0, 0), stepper="event")
    world.add_body(rb.Box((0.0005, 1, 1)), type="static", name="wall")
    world.add_body(
        rb.Capsule(2.8e-4, 7e-4),
        mass=0.01,
        name="rod",
        position=(-0.00078 - 1e-10, 0, 0),
        linear_velocity=(-2e-8, 14, 0),
        angular_velocity=(0, 0, -5e4),
    )
    for _ in range(5):
        begin = time.perf_counter()
        world.step()
        assert time.perf_counter() - begin < STEP
        assert world.stats.queries_capped == 0
        assert world.stats.events == 0
