"""A ball with restitution dropped on a tower of more than 16 contacts bounced as high as the time step
let it: the gap was closed by the one solve of the island, without restitution. Under `reflections` the
floor's restitution of 0, below boxes at rest, took the ball's."""

import numpy as np
import pytest

import rb_physics as rb


@pytest.mark.parametrize("boxes", [2, 4, 8])
@pytest.mark.parametrize("dt", [5e-4, 1e-3])
@pytest.mark.parametrize("law", ["sequential", "simultaneous", "reflections"])
def test_a_ball_bounces_off_a_heavy_tower(law: str, dt: float, boxes: int) -> None:
    world = rb.World(dt=dt, impact_law=law)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static")
    for k in range(boxes):
        world.add_body(rb.Box((0.5, 0.5, 0.1)), mass=1e9, position=(0, 0, 0.1 + 0.2 * k))
    top = 0.2 * boxes + 0.1
    ball = world.add_body(rb.Sphere(0.1), mass=1e-3, position=(0, 0, top + 1.0), restitution=0.8)
    fell, apex = False, 0.0
    for _ in range(round(1.2 / dt)):
        world.step()
        fell = fell or ball.linear_velocity[2] > 0
        if fell:
            apex = max(apex, ball.position[2] - top)
    # 0.8² of 1 m, and what a step at the top may miss of it: g dt²/8.
    np.testing.assert_allclose(apex, 0.64, atol=2e-6)
