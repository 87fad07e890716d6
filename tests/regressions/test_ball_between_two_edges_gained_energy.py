"""A ball that struck from edge to edge met each of them every second time only.

The edge it had just left was taken for one that takes part in the step: the meeting within the step
went unseen, the correction lifted the ball out of the overlap, and the energy grew with each pass
until the ball was shot through the floor.
"""

import pytest

import rb_physics as rb


@pytest.mark.parametrize("dt", [1e-3, 2.5e-3, 1e-2])
@pytest.mark.parametrize("offset", [0.003, -0.001, 1e-4, 0.0123])
@pytest.mark.parametrize("restitution", [1.0, 0.3])
def test_ball_between_two_edges(restitution, offset, dt):
    world = rb.World(dt=dt)
    more = {"friction": 0.0, "restitution": restitution}
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **more)
    for side in (-1, 1):  # the gap is as wide as the ball
        world.add_body(
            rb.Box((0.5, 0.5, 0.2)), type="static", position=(side * 0.6, 0, 0.2), **more
        )
    ball = world.add_body(rb.Sphere(0.1), mass=1.0, position=(offset, 0.01, 1.0), **more)
    energy = world.kinetic_energy + world.potential_energy
    for _ in range(round(1.2 / dt)):
        world.step()
        after = world.kinetic_energy + world.potential_energy
        assert after <= energy + 1e-10  # J, of 10: rounding of a thousand steps
        assert world.stats.max_penetration <= 1e-10  # m, the touch distance of a 0.1 m ball
        energy = after
    assert ball.com_position[2] >= 0.1 - 1e-9
