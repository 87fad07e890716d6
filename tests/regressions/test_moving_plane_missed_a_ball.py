"""A rising half-space passed into a ball that came down at it: the pair was found one step late."""

import pytest

import rb_physics as rb

G = 9.81


@pytest.mark.parametrize("velocity", [(0, 0, 1.0), (3.0, -2.0, 1.0), (0, 0, -1.0)])
def test_bounces_on_a_moving_plane(velocity):
    world = rb.World(dt=1e-3)
    plane = world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="kinematic",
        linear_velocity=velocity,
        restitution=0.8,
    )
    ball = world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 1.1), linear_velocity=velocity)
    bounces, before = 0, 0.0
    for _ in range(2500):
        world.step()
        speed = ball.linear_velocity[2] - velocity[2]
        bounces += before < 0 < speed
        before = speed
        height = ball.position[2] - plane.position[2] - 0.1 + speed**2 / (2 * G)
        # The plane's place is a sum of 2500 shifts of a millimetre: 1e-13 m.
        assert height == pytest.approx(0.8 ** (2 * bounces), rel=1e-10)
    assert bounces >= 3


def test_a_plane_that_turns_meets_what_is_far_from_its_origin():
    """1 m out a plane turning at 5 rad/s rises 5 mm in a step; the ball must be seen in time."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="kinematic", angular_velocity=(0, -5.0, 0)
    )
    world.add_body(rb.Sphere(0.05), mass=1.0, position=(1.0, 0, 0.1), friction=0.0)
    for _ in range(30):
        world.step()
        # The path of the surface curves: what is left is of third order in the step.
        assert world.stats.max_penetration < 1e-7
