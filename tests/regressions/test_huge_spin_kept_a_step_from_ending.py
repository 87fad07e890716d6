"""A finite but absurd torque or spin kept one step busy for minutes: free motion turned it piece by
piece."""

import numpy as np
import pytest

import rb_physics as rb


def lying(shape):
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground")
    return world, world.add_body(shape, mass=1.0, position=(0, 0, 0.1), name="body")


SHAPES = {
    "box": rb.Box((0.2, 0.15, 0.1)),
    "capsule": rb.Capsule(0.1, 0.2),
    "cylinder": rb.Cylinder(0.2, 0.1),
}


@pytest.mark.timeout(30)  # minutes before; the whole file takes a second
@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("spin", [1e8, 1e12, 1e16, 1e29])
def test_absurd_spins_are_told(shape, spin):
    world, body = lying(shape)
    body.angular_velocity = (spin, 0.3 * spin, 0)
    with pytest.raises(rb.DivergedError, match="'body'.*more than 1e4 rad"):
        world.step()


@pytest.mark.timeout(30)
@pytest.mark.parametrize("torque", [1e10, 1e13, 1e100])
def test_absurd_torques_are_told_and_nothing_has_moved(torque):
    world, body = lying(SHAPES["box"])
    world.step(10)
    before = world.positions
    body.apply_wrench(force=(0, 0, 0), torque=(torque, 0, 0))
    with pytest.raises(rb.DivergedError):
        world.step()
    np.testing.assert_array_equal(world.positions, before)
    body.clear_wrenches()
    world.step()


@pytest.mark.timeout(30)
def test_a_needle_may_spin_fast():
    """500 rad a step about a transverse axis: the same attitude as in a thousand small steps."""
    ends = []
    for dt, steps in ((5e-3, 1), (5e-6, 1000)):
        world = rb.World(gravity=(0, 0, 0), dt=dt)
        needle = world.add_body(rb.Box((7e-5, 7e-5, 1.4e-3)), density=8e3, name="needle")
        needle.angular_velocity = (1e5, 3e4, 100.0)
        world.step(steps)
        ends.append(needle.orientation)
    apart = min(np.linalg.norm(ends[0] - ends[1]), np.linalg.norm(ends[0] + ends[1]))
    # Rounding of the attitude tilts L against an axis of 200 times less inertia: 2e-16 * 200 * 1e5
    # rad/s * 5 ms = 2e-11 rad, a few times.
    assert apart <= 3e-10
