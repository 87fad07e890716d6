"""A stack that slides apart in flight carries nothing, though it did the step before."""

import numpy as np

import rb_physics as rb


def test_contacts_that_lose_their_load_while_they_slide():
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static")
    shape = rb.Box((0.1, 0.1, 0.1))
    for k in range(2):  # a smaller island first: its arrays were used for the larger one
        world.add_body(shape, mass=1.0, position=(-3, 0, 0.1 + 0.2 * k))
    stack = [world.add_body(shape, mass=1.0, position=(0, 0, 0.1 + 0.2 * k)) for k in range(8)]
    world.step(5)
    sideways = np.where(np.arange(8) % 2 == 0, 0.2, -0.2)
    for body, v in zip(stack, sideways, strict=True):
        body.linear_velocity = (v, 0, 3.0)
    world.step()
    got = np.array([body.linear_velocity for body in stack])
    # Free flight: nothing presses, so nothing rubs. Speeds are read to 16 digits.
    np.testing.assert_allclose(got[:, 0], sideways, atol=1e-12)
    np.testing.assert_allclose(got[:, 2], 3.0 - 9.81e-3, atol=1e-12)
