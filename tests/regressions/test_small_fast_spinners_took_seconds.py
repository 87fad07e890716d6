"""Poses of a body that turns a hundred times in a step were worked out from the start each time."""

import time

import numpy as np

import rb_physics as rb


def test_a_spinning_needle_beside_a_wall():
    world = rb.World(dt=5e-3, gravity=(0, 0, 0))
    world.add_body(rb.Box((1, 1, 0.0005)), type="static", name="wall")
    needle = world.add_body(
        rb.Box((7e-5, 7e-5, 1.4e-3)),
        mass=0.01,
        name="needle",
        position=(0, 0, 2.5e-3),
        linear_velocity=(0, 0, 0.1),
        angular_velocity=(6e4, 2e4, 5e4),
    )
    start = time.perf_counter()
    world.step(4)
    assert time.perf_counter() - start < 4.0  # 0.1 s here; tens of seconds before
    assert np.isfinite(needle.position).all()
