"""S7: test- and find-intersection, the contact time, and steps that split there (public face)."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage, multiply, rotation, turn

G = 9.81


def ball_over_ground(height, velocity=(0, 0, 0), radius=0.1, gravity=(0, 0, -G), **keywords):
    world = rb.World(gravity=gravity, **keywords)
    ground = world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    ball = world.add_body(
        rb.Sphere(radius), mass=1.0, position=(0, 0, height + radius), linear_velocity=velocity
    )
    return world, ground, ball


@pytest.mark.parametrize("height", [1e-3, 0.2, 1.0, 30.0])
@pytest.mark.parametrize("speed", [0.0, -3.0, 2.0])
def test_contact_time_of_a_falling_ball(height, speed):
    _world, ground, ball = ball_over_ground(height, (0.3, 0, speed))
    exact = (speed + np.sqrt(speed**2 + 2 * G * height)) / G
    t = rb.time_of_impact(ball, ground, 2 * exact)
    # The root is found to the touch distance (1e-9 of the radius) at the speed of the impact.
    assert t == pytest.approx(exact, abs=2e-9 * 0.1 / np.sqrt(speed**2 + 2 * G * height))
    assert rb.time_of_impact(ball, ground, 0.99 * exact) is None


def test_queries_do_not_move_the_world():
    world, ground, ball = ball_over_ground(0.5)
    before = world.state_hash
    assert not rb.test_intersection(ball, ground)
    assert len(rb.find_contacts(ball, ground)) == 0
    rb.distance(ball, ground)
    rb.time_of_impact(ball, ground, 1.0)
    assert world.state_hash == before


@pytest.mark.parametrize("gap", [-0.01, -1e-6, 1e-6, 0.01])
def test_test_and_find_intersection_agree(gap):
    _world, ground, ball = ball_over_ground(gap)
    assert rb.test_intersection(ball, ground) == (gap < 0)
    found = rb.find_contacts(ball, ground, margin=0.02)
    assert len(found) == 1
    assert found["separation"][0] == pytest.approx(gap, abs=1e-15)  # rounding of 0.1
    np.testing.assert_allclose(found["normal"][0], (0, 0, 1), atol=1e-15)
    assert rb.distance(ball, ground).distance == pytest.approx(gap, abs=1e-15)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("dt", [1e-3, 1e-2, 7e-2])
def test_the_step_splits_at_the_contact_time(stepper, dt):
    """After an elastic bounce the ball is where the parabola from the contact time takes it."""
    height, rebound = 0.37, 0.7
    world, _ground, ball = ball_over_ground(height, dt=dt, stepper=stepper)
    ball.restitution = rebound
    fall = np.sqrt(2 * height / G)
    steps = int(fall / dt) + 1
    world.step(steps)
    t = world.time - fall
    up = rebound * G * fall
    # Contact time to 1e-10 m / 3 m/s; the rest is rounding.
    assert ball.position[2] - 0.1 == pytest.approx(up * t - 0.5 * G * t * t, abs=1e-12)
    assert ball.linear_velocity[2] == pytest.approx(up - G * t, abs=1e-10)


def test_a_turning_box_meets_the_floor_with_its_corner():
    """Contact time of a box that turns about y without falling: a corner sinks as it turns."""
    half, spin = np.array([0.3, 0.1, 0.1]), 2.0
    world = rb.World(gravity=(0, 0, 0))
    ground = world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    height = 0.25
    box = world.add_body(
        rb.Box(half), mass=1.0, position=(0, 0, height), angular_velocity=(0, spin, 0)
    )
    # Lowest corner at angle a: h - (0.3 sin a + 0.1 cos a).
    radius, phase = np.hypot(0.3, 0.1), np.arctan2(0.1, 0.3)
    exact = (np.arcsin(height / radius) - phase) / spin
    assert rb.time_of_impact(box, ground, 1.0) == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_two_bodies_that_cross_within_a_step_do_not_pass(stepper):
    """100 m/s against a ball as large as a tenth of the way of one step."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-2, stepper=stepper)
    a = world.add_body(
        rb.Sphere(0.05), mass=1.0, position=(-0.7, 0, 0), linear_velocity=(100, 0, 0), restitution=1
    )
    b = world.add_body(rb.Sphere(0.05), mass=1.0, restitution=1)
    world.step(2)
    np.testing.assert_allclose(a.linear_velocity, 0, atol=1e-12)  # rounding of 100
    np.testing.assert_allclose(b.linear_velocity, (100, 0, 0), atol=1e-12)
    contact_time = 0.6 / 100
    # Positions: the contact time is exact to 1e-13 s at 100 m/s.
    np.testing.assert_allclose(b.position[0], 100 * (0.02 - contact_time), atol=1e-10)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_a_thin_wall_stops_a_bullet(stepper):
    world = rb.World(gravity=(0, 0, 0), dt=1e-2, stepper=stepper)
    world.add_body(rb.Box((0.001, 1, 1)), type="static", restitution=0.5)
    bullet = world.add_body(
        rb.Sphere(0.01), mass=0.01, position=(-3, 0.2, 0.1), linear_velocity=(300, 0, 0)
    )
    world.step(10)
    assert bullet.position[0] < -0.011 + 1e-9
    np.testing.assert_allclose(bullet.linear_velocity, (-150, 0, 0), atol=1e-10)


@pytest.mark.parametrize("attitude", [(0, 0, 0, 1), tuple(turn((1, 2, -1), 0.8))])
def test_many_contact_times_in_one_step(attitude):
    """Balls of different heights land in one long step; each bounces at its own time."""
    stage = Stage(attitude=attitude)
    # Without a threshold every rebound counts, also those that end within the step.
    world = stage.world(0.1, restitution_threshold=0.0)
    stage.plane(world, restitution=0.5)
    heights = 0.02 + 0.004 * np.arange(8)
    balls = [
        stage.add(world, stage.sphere(0.05), 1.0, (0.3 * k, 0, 0.05 + h))
        for k, h in enumerate(heights)
    ]
    world.step()
    for ball, h in zip(balls, heights, strict=True):
        fall = np.sqrt(2 * h / G)
        t = 0.1 - fall
        z = 0.5 * G * fall * t - 0.5 * G * t * t
        assert z > 0, "the case is meant to show the first flight only"
        assert stage.position(world, ball)[2] - 0.05 == pytest.approx(z, abs=1e-12)


def test_moving_kinematic_plane_meets_a_ball_at_the_right_time():
    """A floor that rises: nothing but the relative motion counts."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-2)
    floor = world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="kinematic",
        linear_velocity=(0, 0, 20),
        restitution=1.0,
    )
    ball = world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0.93))
    assert rb.time_of_impact(ball, floor, 1.0) == pytest.approx(0.83 / 20, abs=1e-10)
    world.step(10)
    # At 0.0415 s it leaves at twice the floor's speed.
    assert ball.position[2] == pytest.approx(0.93 + 40 * (0.1 - 0.83 / 20), abs=1e-10)


def test_box_edges_that_cross_find_their_contact_time():
    """Edge against edge, crossed at a right angle, one falling on the other."""
    world = rb.World(gravity=(0, 0, -G))
    on_edge = turn((0, 1, 0), np.pi / 4)
    low = world.add_body(rb.Box((0.1, 1, 0.1)), type="static", orientation=on_edge)
    q = multiply(turn((0, 0, 1), np.pi / 2), on_edge)
    high = world.add_body(rb.Box((0.1, 1, 0.1)), mass=1.0, position=(0, 0, 1.0), orientation=q)
    assert np.allclose(rotation(q) @ (0, 1, 0), (-1, 0, 0))
    gap = 1.0 - 2 * 0.1 * np.sqrt(2)
    exact = np.sqrt(2 * gap / G)
    assert rb.time_of_impact(high, low, 1.0) == pytest.approx(exact, abs=1e-9)
    touching = rb.find_contacts(high, low, margin=gap + 1e-9)
    assert [rb.ContactKind(k) for k in touching["kind"]] == [rb.ContactKind.EDGE_EDGE]
