"""S1: particles, S = [x, v]. A point mass is a body whose rotation is locked."""

import numpy as np
import pytest

import rb_physics as rb


def test_particles_fall_on_their_parabola():
    world = rb.World(gravity=(0.0, 0.0, -9.81), dt=1e-2)
    start = [((0, 0, 10), (1, 2, 3)), ((5, 0, 0), (0, -1, 20))]
    particles = [
        world.add_body(rb.Particle(), mass=m, position=x, linear_velocity=v)
        for m, (x, v) in zip((0.5, 3.0), start, strict=True)
    ]
    world.step(100)
    t = 1.0
    for particle, (x, v) in zip(particles, start, strict=True):
        expected = np.array(x) + t * np.array(v) + 0.5 * t * t * np.array([0, 0, -9.81])
        # 100 exact steps: only rounding adds up, 100 * 2^-52 * 20 m.
        np.testing.assert_allclose(particle.position, expected, atol=1e-12)
        np.testing.assert_allclose(
            particle.linear_velocity, np.array(v) + [0, 0, -9.81], atol=1e-12
        )


def test_a_force_acts_as_F_over_m():
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    particle = world.add_body(rb.Particle(), mass=4.0)
    particle.apply_wrench(force=(2.0, 0.0, 0.0))
    world.step(1000)
    # a = 0.5 m/s²; rounding of 1000 additions.
    np.testing.assert_allclose(particle.linear_velocity, [0.5, 0, 0], atol=1e-13)
    np.testing.assert_allclose(particle.position, [0.25, 0, 0], atol=1e-13)


def test_a_particle_never_turns():
    world = rb.World(dt=1e-3)
    particle = world.add_body(rb.Particle(), mass=1.0)
    particle.apply_wrench(force=(1, 0, 0), torque=(1, 2, 3), point=(0, 5, 0))
    world.step(10)
    np.testing.assert_array_equal(particle.angular_velocity, np.zeros(3))
    np.testing.assert_array_equal(particle.orientation, [0, 0, 0, 1])


def test_a_particle_needs_a_mass_not_a_density():
    world = rb.World()
    with pytest.raises(rb.SceneError, match=r"body 'p': density is 2.0; a particle has no volume"):
        world.add_body(rb.Particle(), density=2.0, name="p")
