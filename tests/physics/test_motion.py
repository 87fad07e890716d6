"""Moving bodies with known behaviour: tumbling, spinning, rolling, colliding, toppling."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage, multiply, rotation, turn

G = 9.81


def needs(name):
    return pytest.mark.xfail(
        not hasattr(rb, name), reason=f"rb.{name} is not in the public face yet", strict=True
    )


def energy(world):
    return world.kinetic_energy + world.potential_energy


# ---- free and pivoting bodies -------------------------------------------------------------------


def test_dzhanibekov():
    """Spun about the middle axis a body flips over and over, with the period of the elliptic integral."""
    from scipy.special import ellipkm1

    moments, spin = np.array([1.0, 2.0, 3.0]), np.array([0.01, 5.0, 0.0])
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    body = world.add_body(rb.Sphere(0.3), mass=1.0, inertia=moments, angular_velocity=spin)
    flips, before = [], 1.0
    for n in range(40000):
        world.step()
        w2 = (rotation(body.orientation).T @ body.angular_velocity)[1]
        if w2 * before < 0:
            flips.append(n + before / (before - w2))  # linear between two steps
        before = w2
    # Landau & Lifshitz section 37, for L² < 2 E I_2 axes 1 and 3 change roles.
    I1, I2, I3 = moments
    twice_energy, L2 = (moments * spin**2).sum(), ((moments * spin) ** 2).sum()
    if twice_energy * I2 > L2:
        I1, I3 = I3, I1
    m1 = (I3 - I1) * (L2 - twice_energy * I2) / ((I3 - I2) * (L2 - twice_energy * I1))
    rate = np.sqrt((I3 - I2) * (L2 - twice_energy * I1) / (I1 * I2 * I3))
    half_period = 2 * ellipkm1(m1) / abs(rate)
    periods = np.diff(flips) * world.dt
    assert len(flips) >= 4
    # Zero crossings interpolated within 1 ms: 1e-6 s; 1 - m1 = 1e-5 is known to 1e-11.
    np.testing.assert_allclose(periods, half_period, atol=2e-6)


def top(tilt, spin, friction=2.0, dt=1e-4):
    """A top: a tiny ball as its tip, mass and moments as those of a gyroscope."""
    tip, length, mass = 1e-6, 0.1, 0.5
    moments = (6e-3, 6e-3, 1e-3)
    world = rb.World(dt=dt)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=friction)
    q = turn((0, 1, 0), tilt)
    R = rotation(q)
    body = world.add_body(
        rb.Sphere(tip),
        mass=mass,
        position=(0, 0, tip),
        orientation=q,
        center_of_mass=(0, 0, length),
        inertia=moments,
        angular_velocity=R @ (0, 0, spin),
        friction=friction,
    )
    return world, body, mass, length, moments


def test_top_on_a_rough_plane_precesses():
    """Fast top on its tip: precession at about m g l / (I3 spin), the tip stays, energy stays."""
    spin = 600.0
    world, body, mass, length, moments = top(0.3, spin)
    start = energy(world)
    angles = []
    for _ in range(10000):
        world.step()
        axis = rotation(body.orientation)[:, 2]
        angles.append(np.arctan2(axis[1], axis[0]))
    rate = np.polyfit(np.arange(10000) * world.dt, np.unwrap(angles), 1)[0]
    # Slow precession of a fast top: corrections are of order m g l I1' cos / (I3 spin)² = 1e-2.
    assert rate == pytest.approx(mass * G * length / (moments[2] * spin), rel=0.03)
    # Rolling without slip on the tip: nothing dissipates; dt 1e-4 resolves the nutation.
    assert energy(world) == pytest.approx(start, rel=1e-5)


def test_top_without_friction_keeps_its_centre_above_one_point():
    """On ice no horizontal force acts: the centre of mass stays above its point, spin is kept."""
    world, body, *_ = top(0.3, 600.0, friction=0.0)
    start = body.com_position
    L3 = moments_spin(body)
    energy_0 = energy(world)
    world.step(5000)
    np.testing.assert_allclose(body.com_position[:2], start[:2], atol=1e-12)
    assert moments_spin(body) == pytest.approx(L3, rel=1e-8)
    assert energy(world) == pytest.approx(energy_0, rel=1e-5)


def moments_spin(body):
    """Angular momentum about the body's third axis."""
    R = rotation(body.orientation)
    return (body.inertia @ (R.T @ body.angular_velocity))[2]


# ---- rolling ------------------------------------------------------------------------------------


def disk(tilt, rolling_friction=0.0, dt=2e-4):
    """Euler's disk: a thin cylinder on its edge, at the steady precession of that tilt."""
    radius, half = 0.04, 1e-3
    mass = 0.4
    world = rb.World(dt=dt)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="static",
        friction=3.0,
        rolling_friction=rolling_friction,
    )
    q = turn((0, 1, 0), tilt)
    # Steady motion with the centre at rest: Omega² = 4 g / (r sin tilt) for a thin disk.
    axis = rotation(q)[:, 2]
    omega = np.sqrt(4 * G / (radius * np.sin(tilt)))
    # The whole spin is along the diameter through the contact: -Omega sin(tilt) of it.
    diameter = rotation(q)[:, 0]
    body = world.add_body(
        rb.Cylinder(radius, half),
        mass=mass,
        position=(0, 0, radius * np.sin(tilt) + half * np.cos(tilt)),
        orientation=q,
        angular_velocity=-omega * np.sin(tilt) * diameter,
        friction=3.0,
        rolling_friction=rolling_friction,
    )
    assert axis[2] > 0
    return world, body, omega


def precession(world, body, steps):
    angles = []
    for _ in range(steps):
        world.step()
        axis = rotation(body.orientation)[:, 2]
        angles.append(np.arctan2(axis[1], axis[0]))
    return np.polyfit(np.arange(steps) * world.dt, np.unwrap(angles), 1)[0]


@pytest.mark.parametrize("dt", [2e-4, 1e-3, 2e-3])
@pytest.mark.parametrize("tilt", [0.2, 0.4, 0.8])
def test_eulers_disk_without_rolling_friction_keeps_its_energy(tilt, dt):
    world, _body, _ = disk(tilt, dt=dt)
    world.step(2)  # the start ignores its thickness: the slip that leaves ends at once
    start = energy(world)
    for _ in range(round(1.0 / dt)):
        world.step()
        # Coulomb rolling without slip dissipates nothing.
        assert energy(world) == pytest.approx(start, rel=1e-6)


def test_eulers_disk_with_rolling_friction_sinks_and_speeds_up():
    world, body, _omega = disk(0.4, rolling_friction=2e-3)
    start = energy(world)
    first = abs(precession(world, body, 500))
    energies = [energy(world)]
    for _ in range(8):
        world.step(500)
        energies.append(energy(world))
    assert (np.diff(energies) < 0).all() and energies[0] < start
    assert abs(precession(world, body, 500)) > 1.05 * first


def test_tippe_top_turns_over():
    """A ball with its centre of mass below its middle, spun fast, raises it by sliding friction."""
    radius, offset, mass = 0.02, 0.004, 0.02
    world = rb.World(dt=2e-4)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.3)
    moment = 0.4 * mass * radius**2
    body = world.add_body(
        rb.Sphere(radius),
        mass=mass,
        position=(0, 0, radius),
        orientation=turn((1, 0, 0), 0.1),
        center_of_mass=(0, 0, -offset),
        inertia=(moment, moment, moment * 0.95),
        angular_velocity=(0, 0, 180.0),
        friction=0.3,
    )
    first = rotation(body.orientation)[2, 2]
    start = energy(world)
    world.step(15000)
    last = rotation(body.orientation)[2, 2]
    assert first > 0.99
    assert last < 0.3, "its axis has turned over, or is about to"
    assert body.com_position[2] > radius - 0.3 * offset
    assert energy(world) < start  # the rise is paid by spin


@needs("Cylinder")
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


# ---- collisions ---------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["simultaneous", "reflections"])
@pytest.mark.parametrize("stage", [Stage(), Stage(attitude=tuple(turn((1, 2, 3), 0.7)))])
@pytest.mark.parametrize("rows", [2, 3, 5])
def test_billiard_break_is_symmetric(law, stage, rows):
    """The cue ball hits the rack head-on: left and right mirror each other to 1e-12."""
    r = 0.0286
    world = stage.world(1e-3, gravity=(0, 0, 0), impact_law=law)
    rack = []
    for k in range(rows):
        for j in range(k + 1):
            x = (k * np.sqrt(3) * r, (2 * j - k) * r, 0)
            rack.append(stage.add(world, stage.sphere(r), 0.17, x, restitution=1.0, friction=0.0))
    stage.add(
        world,
        stage.sphere(r),
        0.17,
        (-2 * r - 2.5e-3, 0, 0),
        velocity=(1, 0, 0),
        restitution=1.0,
        friction=0.0,
    )
    for _ in range(10):
        world.step()
    n = 0
    for k in range(rows):
        row = rack[n : n + k + 1]
        n += k + 1
        for left, right in zip(row, row[::-1], strict=True):
            v, w = stage.velocity(left), stage.velocity(right) * (1, -1, 1)
            np.testing.assert_allclose(v, w, atol=1e-12)
    assert world.kinetic_energy <= 0.5 * 0.17 * stage.mass * stage.size * (1 + 1e-12)


@pytest.mark.soak
@pytest.mark.parametrize(("spacing", "count"), [(0.05, 12), (0.08, 20)])
def test_domino_row(spacing, count):
    """A push runs down the row at a steady speed, and every domino falls on the next."""
    half = np.array([0.004, 0.02, 0.05])
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.6)
    dominoes = [
        world.add_body(rb.Box(half), mass=0.02, position=(spacing * k, 0, half[2]), friction=0.3)
        for k in range(count)
    ]
    dominoes[0].angular_velocity = (0, 3.0, 0)
    dominoes[0].linear_velocity = (0.15, 0, 0)
    fallen = {}
    start = energy(world)
    for n in range(2500):
        world.step()
        for k, d in enumerate(dominoes):
            if k not in fallen and rotation(d.orientation)[2, 2] < np.cos(0.2):
                fallen[k] = n
        if len(fallen) == count:
            break
    assert list(fallen) == list(range(count)), "one after the other"
    speeds = spacing / (np.diff([fallen[k] for k in range(count // 3, count)]) * world.dt)
    # The front of a domino row settles to a speed of the order of sqrt(g h); steady within a fifth.
    assert speeds.std() < 0.2 * speeds.mean()
    assert 0.3 < speeds.mean() / np.sqrt(G * 2 * half[2]) < 3
    assert energy(world) < start + 1e-9
    assert world.stats.max_penetration < 1e-6


# ---- moving ground ------------------------------------------------------------------------------


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


def test_quaternions_stay_normal():
    world = rb.World(dt=1e-3)
    body = world.add_body(rb.Box((0.1, 0.2, 0.3)), mass=1.0, angular_velocity=(10, 20, -30))
    body.orientation = multiply(turn((1, 0, 0), 0.3), turn((0, 1, 0), 0.3))
    world.step(5000)
    assert np.linalg.norm(body.orientation) == pytest.approx(1, abs=1e-15)
