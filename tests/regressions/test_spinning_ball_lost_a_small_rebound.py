"""A fast spinning ball with little restitution did not rebound: its spin counted as an approach that
the next step would bring anyway."""

import numpy as np
import pytest

import rb_physics as rb


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_a_spinning_ball_keeps_its_small_rebound(stepper: str) -> None:
    world = rb.World(dt=1e-3, stepper=stepper, gravity=(0, 0, 0))
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", restitution=0.02, friction=0.0)
    ball = world.add_body(
        rb.Sphere(0.1),
        mass=1.0,
        position=(0, 0, 0.1005),
        linear_velocity=(0.3, 0, -1.0),
        angular_velocity=(0, 30, 0),
        restitution=0.02,
        friction=0.0,
    )
    world.step(2)
    # Newton's law to rounding.
    np.testing.assert_allclose(ball.linear_velocity, (0.3, 0, 0.02), atol=1e-15)
