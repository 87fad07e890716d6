"""Cylinders and balls that roll, and what stops them."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage, turn

G = 9.81


@pytest.mark.parametrize("stage", [Stage(), Stage(attitude=tuple(turn((1, 2, 3), 0.7)))])
def test_rolling_cylinder(stage):
    """Down a slope without slip: a = 2/3 g sin a; friction needed is m g sin a / 3."""
    slope, radius, half = 0.3, 0.1, 0.2
    world = stage.world(1e-3)
    n = np.array([np.sin(slope), 0, np.cos(slope)])
    stage.plane(world, n, friction=0.5)
    body = stage.add(
        world,
        rb.Cylinder(radius, half),
        2.0,
        n * radius,
        turn((1, 0, 0), np.pi / 2),  # axis across the slope
        friction=0.5,
    )
    start = stage.position(world, body)
    world.step(500)
    t = 0.5
    down = np.array([np.cos(slope), 0, -np.sin(slope)])
    moved = stage.position(world, body) - start
    np.testing.assert_allclose(moved, down * (G * np.sin(slope) / 3 * t * t), atol=1e-9)
    np.testing.assert_allclose(
        stage.spin(body), (0, 2 / 3 * G * np.sin(slope) * t / radius, 0), atol=1e-8
    )


@pytest.mark.parametrize("stage", [Stage(), Stage(attitude=tuple(turn((1, 2, 3), 0.7)), size=10.0)])
@pytest.mark.parametrize("ratio", [0.4, 2 / 3])
def test_sphere_rolls_down_a_slope(stage, ratio):
    slope, radius = 0.3, 0.1
    world = stage.world(1e-3)
    n = np.array([np.sin(slope), 0, np.cos(slope)])
    stage.plane(world, n, friction=0.5)
    body = stage.add(
        world,
        stage.sphere(radius),
        2.0,
        n * radius,
        inertia=np.full(3, ratio * 2.0 * radius**2),
        friction=0.5,
    )
    start = stage.position(world, body)
    world.step(500)
    t, a = 0.5, G * np.sin(slope) / (1 + ratio)
    down = np.array([np.cos(slope), 0, -np.sin(slope)])
    moved = stage.position(world, body) - start
    # Constant forces are integrated exactly: rounding of 500 steps.
    np.testing.assert_allclose(moved, down * a * t * t / 2, atol=1e-11)
    np.testing.assert_allclose(stage.velocity(body), down * a * t, atol=1e-11)


def test_rolling_and_spinning_friction_stop_a_ball():
    """m g b / (m r² (1 + 2/5)) decelerates rolling; spinning friction m g s / J the spin."""
    radius, b, s = 0.1, 1e-3, 2e-3
    world = rb.World(dt=1e-3)
    common = {"friction": 0.8, "rolling_friction": b, "spinning_friction": s}
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **common)
    rolling = world.add_body(
        rb.Sphere(radius),
        mass=1.0,
        position=(0, 0, radius),
        linear_velocity=(1, 0, 0),
        angular_velocity=(0, 10, 0),
        **common,
    )
    spinning = world.add_body(
        rb.Sphere(radius), mass=1.0, position=(0, 2, radius), angular_velocity=(0, 0, 10), **common
    )
    world.step(200)
    t = 0.2
    assert rolling.linear_velocity[0] == pytest.approx(1 - G * b / radius / 1.4 * t, abs=1e-9)
    assert spinning.angular_velocity[2] == pytest.approx(
        10 - G * s / (0.4 * radius**2) * t, abs=1e-8
    )
    world.step(15000)
    np.testing.assert_allclose(world.linear_velocities, 0, atol=1e-9)
    np.testing.assert_allclose(world.angular_velocities, 0, atol=1e-9)
