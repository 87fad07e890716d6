"""Belts, lifts, pushers and turntables move what stands on them or in their way."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage

G = 9.81


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("on_box", [False, True])
def test_conveyor_belt(stepper, on_box):
    """Put on a moving belt a box slides for v / (mu g), then rides along at its speed."""
    stage, mu, speed = Stage(stepper=stepper), 0.4, 1.5
    world = stage.world(1e-3)
    shape = rb.Box((50, 1, 0.5)) if on_box else rb.HalfSpace(normal=(0, 0, 1), offset=0.0)
    world.add_body(
        shape,
        type="kinematic",
        position=(0, 0, -0.5 if on_box else 0),
        linear_velocity=(speed, 0, 0),
        friction=mu,
    )
    box = world.add_body(rb.Box((0.1, 0.1, 0.03)), mass=2.0, position=(0, 0, 0.03), friction=mu)
    world.step(200)
    np.testing.assert_allclose(box.linear_velocity, (mu * G * 0.2, 0, 0), atol=1e-10)
    np.testing.assert_allclose(box.contact_wrench[0], (mu * 2 * G, 0, 2 * G), atol=1e-9)
    world.step(800)
    np.testing.assert_allclose(box.linear_velocity, (speed, 0, 0), atol=1e-10)
    slide = speed / (mu * G)
    assert box.position[0] == pytest.approx(speed * (1.0 - slide) + speed * slide / 2, abs=1e-8)
    np.testing.assert_allclose(box.contact_wrench[0], (0, 0, 2 * G), atol=1e-8)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_elevator(stepper):
    """A floor that rises and falls carries a box: N = m (g + a) while its speed changes, m g else."""
    world = rb.World(dt=1e-3, stepper=stepper)
    floor = world.add_body(rb.Box((1, 1, 0.1)), type="kinematic", position=(0, 0, -0.1))
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=3.0, position=(0, 0, 0.1))
    floor.move(linear_velocity=(0, 0, 0.8))
    world.step()
    # Struck from below by a floor that starts at once.
    assert box.linear_velocity[2] == pytest.approx(0.8, abs=1e-10)
    for _ in range(300):
        world.step()
        assert box.contact_wrench[0][2] == pytest.approx(3 * G, abs=1e-8)
    assert box.position[2] - floor.position[2] == pytest.approx(0.2, abs=1e-9)
    floor.move(linear_velocity=(0, 0, 0))  # stops: the box flies on, and lands again
    world.step(10)
    assert box.position[2] - floor.position[2] > 0.2 + 1e-4
    world.step(400)
    assert box.position[2] - floor.position[2] == pytest.approx(0.2, abs=1e-9)
    np.testing.assert_allclose(box.linear_velocity, 0, atol=1e-10)


def test_accelerating_platform_by_poses():
    """Driven by poses with growing speed: the box feels the acceleration, and slips beyond mu g."""
    for a, slips in ((2.0, False), (6.0, True)):
        world = rb.World(dt=1e-3)
        floor = world.add_body(
            rb.Box((5, 1, 0.1)), type="kinematic", position=(0, 0, -0.1), friction=0.4
        )
        box = world.add_body(
            rb.Box((0.1, 0.1, 0.05)), mass=3.0, position=(0, 0, 0.05), friction=0.4
        )
        for n in range(1, 301):
            t = n * world.dt
            floor.move(position=(0.5 * a * t * t, 0, -0.1))
            world.step()
        t = 0.3
        expected = 0.4 * G * t if slips else a * t
        # Poses of a parabola are chords: the platform's speed is half a step late, a dt / 2.
        assert box.linear_velocity[0] == pytest.approx(expected, abs=1.01 * a * world.dt / 2)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_pusher_strikes_with_its_relative_velocity(stepper, restitution):
    """A moving kinematic wall hits a resting ball: v = (1 + eps) times the wall's speed."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-3, stepper=stepper)
    wall = world.add_body(
        rb.Box((0.1, 1, 1)),
        type="kinematic",
        position=(-0.5, 0, 0),
        linear_velocity=(2, 0, 0),
        restitution=restitution,
    )
    ball = world.add_body(rb.Sphere(0.1), mass=5.0)
    world.step(400)
    assert ball.linear_velocity[0] == pytest.approx(2 * (1 + restitution), abs=1e-12)
    t = 0.4 - 0.15
    expected = 0.0 + 2 * (1 + restitution) * t
    assert ball.position[0] == pytest.approx(expected, abs=1e-10)
    assert wall.position[0] == pytest.approx(-0.5 + 0.8, abs=1e-12)


@pytest.mark.parametrize("spin", [0.5, -2.0])
def test_turntable(spin):
    """On a turning table a box near the axis rides along; the force is the centripetal one."""
    world = rb.World(dt=1e-3)
    world.add_body(
        rb.Box((1, 1, 0.1)),
        type="kinematic",
        position=(0, 0, -0.1),
        angular_velocity=(0, 0, spin),
        friction=0.9,
    )
    radius = 0.3
    box = world.add_body(
        rb.Box((0.05, 0.05, 0.02)),
        mass=1.0,
        position=(radius, 0, 0.02),
        linear_velocity=(0, spin * radius, 0),
        angular_velocity=(0, 0, spin),
        friction=0.9,
    )
    world.step(1000)
    angle = spin * 1.0
    # Forces constant within a step cut corners of a circle: second order in dt.
    np.testing.assert_allclose(
        box.position[:2], radius * np.array([np.cos(angle), np.sin(angle)]), atol=2e-6
    )
    force = box.contact_wrench[0]
    assert np.linalg.norm(force[:2]) == pytest.approx(spin**2 * radius, rel=1e-3)
    assert force[2] == pytest.approx(G, abs=1e-8)
