"""A particle that rounding had put into a floor was corrected to a position that is not a number."""

import numpy as np

import rb_physics as rb


def test_a_particle_inside_comes_out():
    world = rb.World(dt=1e-3)
    world.add_body(rb.Box((1, 1, 0.1)), type="static", name="floor", position=(0, 0, -0.1))
    particle = world.add_body(
        rb.Particle(), mass=1.0, name="particle", position=(0.3, 0.2, -1e-6), friction=0.0
    )
    world.step(10)
    assert np.isfinite(particle.position).all()
    assert abs(particle.position[2]) <= 1e-9  # the touch distance
