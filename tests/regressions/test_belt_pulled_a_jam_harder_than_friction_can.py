"""What a correction lifts is taken from the motion of a jam as far as the step gained energy; the work
of a moving belt counted as such a gain, and impulses outside of the cone of friction braked the jam.
"""

import numpy as np
import pytest

import rb_physics as rb


@pytest.mark.parametrize("belt_moves", [True, False])
def test_friction_is_within_its_cone_on_belt_and_floor(belt_moves):
    friction, speed, dt, mass, count = 0.1, 0.5, 2e-3, 10.0, 36
    rng = np.random.default_rng(3)
    world = rb.World(dt=dt)
    world.add_body(
        rb.Box((400, 400, 0.5)),
        type="kinematic",
        position=(0, 0, -0.5),
        linear_velocity=(speed if belt_moves else 0, 0, 0),
        friction=friction,
    )
    start = np.array((0.0 if belt_moves else -speed, 0.0, 0.0))
    for k, i, j in np.ndindex(4, 3, 3):
        q = np.array((0, 0, 0, 1.0)) + rng.normal(size=4) * 0.02
        world.add_body(
            rb.Box((0.2, 0.2, 0.2)),
            mass=mass,
            position=(0.42 * (i - 1), 0.42 * (j - 1), 0.22 + 0.43 * k),
            orientation=q / np.linalg.norm(q),
            linear_velocity=start,
            friction=friction,
        )
    before = count * mass * start
    weight = count * mass * 9.81 * dt
    for step in range(260):
        world.step()
        momentum = mass * world.linear_velocities[1:].sum(axis=0)
        push = momentum - before + np.array((0, 0, weight))
        before = momentum
        if step < 20:
            continue  # they land
        # A thousandth of the weight's: what the solves of a moving jam leave.
        assert np.hypot(push[0], push[1]) <= friction * (push[2] + 1e-3 * weight)
