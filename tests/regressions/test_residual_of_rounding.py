"""Balls that fly along in touch without a load reported a residual of 1: rounding over rounding."""

import numpy as np

import rb_physics as rb
from rb_physics import math as rb_math


def test_touching_balls_in_free_flight():
    q = np.array([0.3, -0.2, 0.5, 0.7])
    R = rb_math.rotation_matrix(q / np.linalg.norm(q))
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    for k in range(5):
        world.add_body(
            rb.Sphere(0.05),
            mass=1.0 + k,
            position=R @ (0.1 * k, 0, 0),
            linear_velocity=R @ (0.7, 0.2, -0.1),
        )
    for _ in range(50):
        world.step()
        assert world.stats.residual <= 1e-8
