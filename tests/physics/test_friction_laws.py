"""Every kind of friction and every way a kinematic body acts, at random numbers, by closed forms."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import multiply, rotation, turn

G = 9.81
STEPPERS = ("fixed", "event")
SEEDS = range(6)
both = pytest.mark.parametrize("stepper", STEPPERS)
seeds = pytest.mark.parametrize("seed", SEEDS)
# Rounding of some hundred steps; an interval is cut where a slide or a turn ends, so that nothing of
# order dt is left.
CLOSE = 1e-9


def slope(world, angle, heading, **material):
    """A plane through the origin that falls along the returned unit vector; its normal; attitude."""
    q = multiply(turn((0, 0, 1), heading), turn((0, 1, 0), angle))
    R = rotation(q)
    world.add_body(rb.HalfSpace(normal=R[:, 2], offset=0.0), type="static", **material)
    return R[:, 0], R[:, 2], q


@both
@seeds
def test_static_friction_holds_and_kinetic_friction_brakes(stepper, seed):
    """Pulled at its centre: below mu_s m g it stays, above it accelerates by (F - mu_k m g) / m."""
    rng = np.random.default_rng(seed)
    mu_k, extra = rng.uniform(0.1, 0.5), rng.uniform(1.1, 2.0)
    mass, dt = 10 ** rng.uniform(-2, 2), rng.choice([5e-4, 1e-3, 4e-3])
    heading = rng.uniform(0, 2 * np.pi)
    along = np.array([np.cos(heading), np.sin(heading), 0])
    half = np.array([0.2, 0.3, 0.02])
    for share in (0.999, 1.001):
        world = rb.World(dt=dt, stepper=stepper)
        material = {"friction": mu_k, "static_friction": extra * mu_k}
        world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **material)
        box = world.add_body(rb.Box(half), mass=mass, position=(0, 0, half[2]), **material)
        force = share * extra * mu_k * mass * G
        box.apply_wrench(force * along, (0, 0, 0))
        world.step(200)
        t = world.time
        if share < 1:
            np.testing.assert_allclose(box.linear_velocity, 0, atol=1e-12)
            np.testing.assert_allclose(
                box.contact_wrench[0], (*(-force * along[:2]), mass * G), rtol=CLOSE
            )
        else:
            a = force / mass - mu_k * G
            np.testing.assert_allclose(box.linear_velocity, a * t * along, atol=CLOSE * a * t)
            moved = box.com_position - (0, 0, half[2])
            np.testing.assert_allclose(moved, 0.5 * a * t**2 * along, atol=CLOSE * a * t**2)


@both
@seeds
def test_spinning_friction_stops_a_ball_after_its_time(stepper, seed):
    """Spin about the vertical falls by s N / J, is 0 after J w / (s N) and stays 0."""
    rng = np.random.default_rng(seed)
    radius, mass = rng.uniform(0.02, 0.3), 10 ** rng.uniform(-2, 2)
    s, spin = rng.uniform(1e-3, 5e-2) * radius, rng.uniform(1, 20) * rng.choice([-1, 1])
    dt = 1e-3
    material = {"friction": 0.5, "spinning_friction": s}
    world = rb.World(dt=dt, stepper=stepper)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **material)
    ball = world.add_body(
        rb.Sphere(radius),
        mass=mass,
        position=(0, 0, radius),
        angular_velocity=(0, 0, spin),
        **material,
    )
    brake = s * G / (0.4 * radius**2)  # rad/s^2
    stop = abs(spin) / brake
    world.step(max(1, int(0.5 * stop / dt)))
    left = spin - np.sign(spin) * brake * world.time
    np.testing.assert_allclose(ball.angular_velocity, (0, 0, left), atol=CLOSE * abs(spin))
    torque = -np.sign(spin) * s * mass * G
    assert ball.contact_wrench[1][2] == pytest.approx(torque, rel=1e-8)
    world.step(int(0.6 * stop / dt) + 2)
    np.testing.assert_allclose(ball.angular_velocity, 0, atol=CLOSE * abs(spin))
    np.testing.assert_allclose(ball.linear_velocity, 0, atol=1e-12)


@both
@seeds
def test_rolling_friction_on_a_slope(stepper, seed):
    """b: the arm of rolling friction. Held while tan alpha <= b / r; else (g sin a - b g cos a / r) / (1 + k)."""
    rng = np.random.default_rng(seed)
    radius, mass, k = (
        rng.uniform(0.02, 0.3),
        10 ** rng.uniform(-2, 2),
        rng.choice([0.4, 2 / 3, 0.25]),
    )
    b = rng.uniform(0.01, 0.2) * radius
    for share in (0.98, 1.5):
        angle = np.arctan(share * b / radius)
        world = rb.World(dt=1e-3, stepper=stepper)
        material = {"friction": 1.0, "rolling_friction": b}
        down, up, _ = slope(world, angle, rng.uniform(0, 6), **material)
        inertia = np.full(3, k * mass * radius**2)
        start = radius * up
        ball = world.add_body(
            rb.Sphere(radius), mass=mass, position=start, inertia=inertia, **material
        )
        world.step(300)
        t = world.time
        a = max(0.0, G * np.sin(angle) - b / radius * G * np.cos(angle)) / (1 + k)
        scale = max(a * t, 1e-3)
        np.testing.assert_allclose(ball.linear_velocity, a * t * down, atol=CLOSE * scale)
        np.testing.assert_allclose(
            ball.com_position - start, 0.5 * a * t**2 * down, atol=CLOSE * scale
        )
        spin = np.cross(up, down) * a * t / radius
        np.testing.assert_allclose(ball.angular_velocity, spin, atol=CLOSE * scale / radius)


@both
@seeds
def test_a_kinematic_wall_strikes_then_pushes(stepper, seed):
    """Struck at its centre a box takes V + eps (V - v), then the wall pushes it with mu m g."""
    rng = np.random.default_rng(seed)
    mass, mu, V = 10 ** rng.uniform(-2, 2), rng.uniform(0.1, 0.6), rng.uniform(0.2, 2.0)
    dt, eps = 1e-3, rng.choice([0.0, 0.4, 0.9])
    world = rb.World(dt=dt, stepper=stepper, friction_combine="min", restitution_combine="min")
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=mu)
    half = np.array([0.1, 0.15, 0.05])
    gap = 2.4 * dt * V
    wall = world.add_body(
        rb.Box((0.05, 0.5, 0.05)),
        type="kinematic",
        position=(-0.05 - half[0] - gap, 0, half[2]),
        linear_velocity=(V, 0, 0),
        friction=0.0,
        restitution=eps,
    )
    box = world.add_body(
        rb.Box(half), mass=mass, position=(0, 0, half[2]), friction=10.0, restitution=1.0
    )
    world.step(3)
    after = 0.6 * dt
    expected = (1 + eps) * V - mu * G * after if eps > 0 else V
    # Normal impulses of the floor stay those of the weight: friction of the strike is nothing.
    np.testing.assert_allclose(box.linear_velocity, (expected, 0, 0), atol=CLOSE)
    while box.linear_velocity[0] > V * (1 + 1e-9) or world.contacts["body_b"].max() < wall.row:
        world.step()
        assert world.time < 20
    world.step(20)
    np.testing.assert_allclose(box.linear_velocity, (V, 0, 0), atol=1e-9)
    push = world.contacts[world.contacts["body_b"] == wall.row]["force"].sum(axis=0)
    np.testing.assert_allclose(push, (mu * mass * G, 0, 0), rtol=1e-8, atol=1e-8 * mass)
    assert push[0] > 0


@both
@seeds
def test_a_kinematic_lift_carries(stepper, seed):
    """Its speed set anew each step: the load's mean contact force is m (g + a), at any a > -g."""
    rng = np.random.default_rng(seed)
    mass, dt = 10 ** rng.uniform(-2, 2), 1e-3
    world = rb.World(dt=dt, stepper=stepper)
    lift = world.add_body(
        rb.Box((0.5, 0.5, 0.1)), type="kinematic", position=(0, 0, -0.1), friction=1.0
    )
    box = world.add_body(
        rb.Box((0.1, 0.2, 0.05)), mass=mass, position=(0.1, 0.05, 0.05), friction=1.0
    )
    world.step()
    speed = np.zeros(3)
    for _ in range(40):
        a = np.append(rng.uniform(-2, 2, 2), rng.uniform(-4, 8))
        speed = speed + a * dt
        lift.linear_velocity = speed
        world.step()
        np.testing.assert_allclose(box.linear_velocity, speed, atol=1e-10)
        np.testing.assert_allclose(
            box.contact_wrench[0], mass * (a + (0, 0, G)), rtol=1e-7, atol=1e-7 * mass
        )


def test_angular_momentum_of_thrown_boxes_about_a_fixed_point():
    """Impulses act on both bodies at one point: their moments cancel as well as they do."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        world = rb.World(gravity=(0, 0, 0), dt=2e-3)
        for k in range(5):
            direction = np.array([np.cos(1.26 * k), np.sin(1.26 * k), 0.1 * k])
            world.add_body(
                rb.Box(rng.uniform(0.05, 0.15, 3)),
                mass=10 ** rng.uniform(-1, 1),
                position=0.4 * direction,
                orientation=turn(rng.normal(size=3), rng.uniform(0, 3)),
                linear_velocity=-2 * direction,
                angular_velocity=rng.normal(size=3) * 5,
                friction=0.5,
                restitution=0.4,
            )
        before = world.angular_momentum
        struck = 0
        for _ in range(200):
            world.step()
            struck += len(world.contacts)
        assert struck > 0
        scale = sum(b.mass for b in world.bodies) * 2 * 0.5
        # Momenta stay to rounding; what shows in x cross p is how far bodies are moved without them
        # (overlaps, rebounds that are over by the step's end): some 1e-6 m in these steps.
        np.testing.assert_allclose(world.angular_momentum, before, atol=1e-5 * scale)


def test_static_friction_holds_up_to_its_own_limit():
    """Pushed slowly harder, the box starts at static mu; once it slides, kinetic mu acts."""
    world = rb.World(dt=1e-3)
    common = {"friction": 0.3, "static_friction": 0.5}
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **common)
    box = world.add_body(rb.Box((0.1, 0.1, 0.02)), mass=1.0, position=(0, 0, 0.02), **common)
    started = None
    for n in range(3000):
        push = 2.0 * n * world.dt
        box.apply_wrench(force=(push, 0, 0), point=(0, 0, -0.02), frame="body", duration=0)
        world.step()
        if np.linalg.norm(box.linear_velocity) > 1e-9:
            started = push
            break
        assert box.contact_wrench[0][0] == pytest.approx(-push, abs=1e-9)
    assert started == pytest.approx(0.5 * G, abs=2.0 * world.dt)
    box.apply_wrench(force=(started, 0, 0), point=(0, 0, -0.02), frame="body")
    v = box.linear_velocity[0]
    world.step(100)
    assert box.linear_velocity[0] - v == pytest.approx((started - 0.3 * G) * 0.1, abs=1e-9)


@pytest.mark.parametrize(("stepper", "boxes"), [("fixed", 2), ("fixed", 4), ("event", 6)])
def test_a_stack_slides_to_rest_as_one(stepper, boxes):
    """v² / (2 μ g), straight on, for islands that have their slides' ends looked for."""
    friction, speed, heading = 0.3, 1.3, np.array([np.cos(0.4), np.sin(0.4), 0])
    world = rb.World(dt=5e-3, stepper=stepper)
    world.add_body(rb.HalfSpace((0, 0, 1), 0), type="static", friction=friction)
    stack = [
        world.add_body(
            rb.Box((0.2, 0.2, 0.02)),
            mass=1 + k,
            position=(0, 0, 0.02 + 0.04 * k),
            linear_velocity=speed * heading,
            friction=friction,
        )
        for k in range(boxes)
    ]
    world.step(110)
    for box in stack:
        stop = speed**2 / (2 * friction * G) * heading
        np.testing.assert_allclose(box.com_position[:2], stop[:2], rtol=0, atol=CLOSE)
        np.testing.assert_allclose(box.linear_velocity, 0, atol=CLOSE)
