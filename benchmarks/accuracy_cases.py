"""The cases of the accuracy table: a scene, its exact answer, and how far we are from it.

Every case takes a `Stage` and returns errors by name, relative unless said otherwise. Only the
public Python face is used. `Watch` keeps the worst solver residual and energy gain of every step.
"""

from __future__ import annotations

import numpy as np

import rb_physics as rb

from .free_rotation import attitude_of_free_rotation
from .stage import GRAVITY, Stage, angle_between, multiply, rotation, turn

g = GRAVITY


class Watch:
    """Steps a world and keeps the worst of what `world.stats` says."""

    def __init__(self, world: rb.World) -> None:
        self.world = world
        self.residual = 0.0
        self.energy_gain = 0.0

    def step(self) -> None:
        self.world.step()
        self.residual = max(self.residual, self.world.stats.residual)
        self.energy_gain = max(self.energy_gain, self.world.stats.energy_error)

    def report(self, **errors: float) -> dict[str, float]:
        return {**errors, "residual": self.residual, "energy gain": self.energy_gain}


# ---- free motion --------------------------------------------------------------------------------


def free_body(
    stage: Stage,
    dt: float = 1e-3,
    seconds: float = 60.0,
    moments=(1.0, 2.0, 3.0),
    spin=(0.01, 5.0, 0.01),
) -> dict[str, float]:
    """A free body near its unstable axis: energy and L stay, the attitude follows the closed form."""
    world = stage.world(dt)
    body = stage.add(world, stage.box((0.3, 0.2, 0.1)), 1.0, inertia=moments, spin=spin)
    q0 = body.orientation
    inertia = np.asarray(moments)
    L0 = stage.vector(inertia * spin)
    energy0 = 0.5 * np.dot(inertia * spin, spin)
    steps = round(seconds / (dt * stage.dt_factor))
    energy = momentum = 0.0
    chunks = 60
    for _ in range(chunks):
        world.step(steps // chunks)
        w = rotation(body.orientation).T @ body.angular_velocity * stage.time
        L = rotation(body.orientation) @ (inertia * w)
        energy = max(energy, abs(0.5 * np.dot(inertia * w, w) / energy0 - 1))
        momentum = max(momentum, np.linalg.norm(L - L0) / np.linalg.norm(L0))
    exact = attitude_of_free_rotation(moments, spin, world.time / stage.time)
    return {
        "energy": energy,
        "L": float(momentum),
        "attitude (rad)": angle_between(body.orientation, multiply(q0, exact)),
    }


# ---- impacts ------------------------------------------------------------------------------------


def bouncing_ball(
    stage: Stage, restitution: float = 0.8, dt: float = 1e-3, seconds: float = 10.0
) -> dict[str, float]:
    """Dropped by 1 m: the k-th apex is eps^(2k) m. Height z + v²/2g at every step between bounces."""
    radius = 0.1
    world = stage.world(dt)
    stage.plane(world, restitution=restitution)
    ball = stage.add(world, stage.sphere(radius), 1.0, (0, 0, 1 + radius), restitution=restitution)
    watch = Watch(world)
    bounces, error, above, before = 0, 0.0, 0.0, 0.0
    for _ in range(round(seconds / (dt * stage.dt_factor))):
        watch.step()
        speed = stage.velocity(ball)[2]
        if before < 0 < speed:
            bounces += 1
        before = speed
        height = stage.position(world, ball)[2] - radius + speed**2 / (2 * g)
        above = max(above, height - 1)
        # The fifth flight counts up to its apex: the sixth bounce may be one the Zeno rule ends.
        if bounces < 5 or restitution == 1 or (bounces == 5 and speed > 0):
            error = max(error, abs(height / restitution ** (2 * bounces) - 1))
    if bounces < (5 if restitution < 1 else 3):
        raise AssertionError(f"the ball bounced only {bounces} times")
    return watch.report(**{"apex": error, "above the start": above})


def elastic_ball(stage: Stage, dt: float = 1e-3, seconds: float = 10.0) -> dict[str, float]:
    """eps = 1: the energy stays, and never exceeds the start's."""
    result = bouncing_ball(stage, 1.0, dt, seconds)
    result["energy"] = result.pop("apex")
    return result


def newtons_cradle(
    stage: Stage, balls: int = 5, dt: float = 1e-3, struck: int = 1, restitution: float = 1.0
) -> dict[str, float]:
    """``struck`` balls hit a row of touching ones: as many leave at the other end (law reflections)."""
    radius, speed = 0.05, 1.0
    world = stage.world(dt, gravity=(0, 0, 0), impact_law="reflections")
    row = []
    for k in range(balls):
        moving = k < struck
        # 2.3 steps of flight before the impact.
        x = 2 * radius * k - (2.3e-3 * speed if moving else 0.0)
        row.append(
            stage.add(
                world,
                stage.sphere(radius),
                1.0,
                (x, 0, 0),
                velocity=(speed if moving else 0.0, 0, 0),
                restitution=restitution,
                friction=0.0,
            )
        )
    watch = Watch(world)
    for _ in range(round(0.02 / (dt * stage.dt_factor))):
        watch.step()
    v = np.array([stage.velocity(ball) for ball in row])
    exact = np.zeros((balls, 3))
    exact[balls - struck :, 0] = speed
    return watch.report(velocities=float(np.abs(v - exact).max()))


def oblique_bounce(
    stage: Stage,
    friction: float = 0.3,
    restitution: float = 0.6,
    velocity=(1.0, 0.4, -2.0),
    spin=(3.0, -20.0, 7.0),
    dt: float = 1e-3,
    ratio: float = 0.4,
) -> dict[str, float]:
    """A spinning ball strikes a rough floor: dv_t = -u_hat min(mu (1 + eps) |v_n|, |u| / (1 + 1/k)),

    k = J / (m r²) = 2/5; the spin follows from r x impulse."""
    radius, mass = 0.1, 1.0
    world = stage.world(dt, gravity=(0, 0, 0))
    stage.plane(world, friction=friction, restitution=restitution)
    velocity, spin = np.asarray(velocity), np.asarray(spin)
    ball = stage.add(
        world,
        stage.sphere(radius),
        mass,
        (0, 0, radius - 2.4 * dt * velocity[2]),
        velocity=velocity,
        spin=spin,
        inertia=np.full(3, ratio * mass * radius**2),
        friction=friction,
        restitution=restitution,
    )
    watch = Watch(world)
    for _ in range(round(6 / stage.dt_factor)):
        watch.step()
    arm = np.array([0, 0, -radius])
    slip = velocity + np.cross(spin, arm)
    slip[2] = 0.0
    u = np.linalg.norm(slip)
    push = min(friction * (1 + restitution) * -velocity[2], u / (1 + 1 / ratio))
    impulse = -push * slip / u if u > 0 else np.zeros(3)
    impulse[2] = -(1 + restitution) * velocity[2]
    v = velocity + impulse
    w = spin + np.cross(arm, impulse) / (ratio * radius**2)
    return watch.report(
        velocity=float(np.linalg.norm(stage.velocity(ball) - v) / np.linalg.norm(velocity)),
        spin=float(np.linalg.norm(stage.spin(ball) - w) / np.linalg.norm(w)),
    )


# ---- friction -----------------------------------------------------------------------------------


def _incline(stage: Stage, slope: float, friction: float, dt: float, heading: float, on_box: bool):
    """A box on a slope that falls along ``heading``; returns world, box, unit vector downhill."""
    world = stage.world(dt)
    angle = np.arctan(slope)
    q = multiply(turn((0, 0, 1), heading), turn((0, 1, 0), angle))
    R = rotation(q)
    if on_box:
        stage.fixed_box(world, (60.0, 2.0, 0.5), R @ (0, 0, -0.5), q, friction=friction)
    else:
        stage.plane(world, R[:, 2], friction=friction)
    half = np.array([0.15, 0.1, 0.05])
    body = stage.add(world, stage.box(half), 1.0, R @ (0, 0, half[2]), q, friction=friction)
    return world, body, R[:, 0], angle


def box_on_incline(
    stage: Stage,
    fraction: float = 0.9,
    friction: float = 0.5,
    dt: float = 1e-3,
    seconds: float = 3.0,
    heading: float = 0.0,
    on_box: bool = False,
) -> dict[str, float]:
    """tan alpha = fraction mu below 1: it does not move. Creep in m/s, at any step or on average."""
    world, body, _, _ = _incline(stage, fraction * friction, friction, dt, heading, on_box)
    watch = Watch(world)
    start = stage.position(world, body)
    creep = 0.0
    for _ in range(round(seconds / (dt * stage.dt_factor))):
        watch.step()
        creep = max(creep, np.linalg.norm(stage.velocity(body)))
    moved = np.linalg.norm(stage.position(world, body) - start) / seconds
    return watch.report(**{"creep (m/s)": float(max(creep, moved))})


def box_down_incline(
    stage: Stage,
    fraction: float = 1.01,
    friction: float = 0.5,
    dt: float = 1e-3,
    seconds: float = 3.0,
    heading: float = 0.0,
    on_box: bool = False,
) -> dict[str, float]:
    """tan alpha = fraction mu above 1: v = g (sin alpha - mu cos alpha) t, half of it times t."""
    world, body, down, angle = _incline(stage, fraction * friction, friction, dt, heading, on_box)
    watch = Watch(world)
    start = stage.position(world, body)
    for _ in range(round(seconds / (dt * stage.dt_factor))):
        watch.step()
    t = world.time / stage.time
    speed = g * (np.sin(angle) - friction * np.cos(angle)) * t
    moved = stage.position(world, body) - start
    return watch.report(
        distance=float(np.linalg.norm(moved / (0.5 * speed * t) - down)),
        velocity=float(np.linalg.norm(stage.velocity(body) / speed - down)),
    )


def box_slides_to_rest(
    stage: Stage,
    heading: float = 0.0,
    friction: float = 0.4,
    speed: float = 2.0,
    dt: float = 1e-3,
    half=(0.1, 0.1, 0.02),
    on_box: bool = False,
) -> dict[str, float]:
    """Stops after v²/(2 mu g), straight on (degrees off the line)."""
    world = stage.world(dt)
    if on_box:
        stage.fixed_box(world, (10.0, 10.0, 0.5), (0, 0, -0.5), friction=friction)
    else:
        stage.plane(world, friction=friction)
    direction = np.array([np.cos(heading), np.sin(heading), 0.0])
    body = stage.add(
        world, stage.box(half), 1.0, (0, 0, half[2]), velocity=speed * direction, friction=friction
    )
    watch = Watch(world)
    duration = 1.2 * speed / (friction * g)
    for _ in range(round(duration / (dt * stage.dt_factor))):
        watch.step()
    moved = stage.position(world, body) - (0, 0, half[2])
    side = np.cross(direction, moved)[2]
    return watch.report(
        **{
            "distance": float(abs(moved @ direction / (speed**2 / (2 * friction * g)) - 1)),
            "off (deg)": float(np.degrees(abs(np.arctan2(side, moved @ direction)))),
            "left over (m/s)": float(np.linalg.norm(stage.velocity(body))),
        }
    )


def sphere_starts_to_roll(
    stage: Stage,
    heading: float = 0.0,
    friction: float = 0.3,
    speed: float = 2.0,
    dt: float = 1e-3,
    spin=(0.0, 0.0, 0.0),
    ratio: float = 0.4,
) -> dict[str, float]:
    """Set sliding without spin it ends rolling at 5/7 v0, after 12 v0² / (49 mu g)."""
    radius = 0.1
    world = stage.world(dt)
    stage.plane(world, friction=friction)
    direction = np.array([np.cos(heading), np.sin(heading), 0.0])
    spin = np.asarray(spin, float)
    body = stage.add(
        world,
        stage.sphere(radius),
        1.0,
        (0, 0, radius),
        velocity=speed * direction,
        spin=spin,
        inertia=np.full(3, ratio * radius**2),
        friction=friction,
    )
    watch = Watch(world)
    v0 = speed * direction
    slip = v0 + np.cross(spin, (0, 0, -radius))
    slip[2] = 0.0
    # The angular momentum about the floor stays: v_roll = v0 - slip k / (1 + k), k = J / (m r²).
    v_roll = v0 - slip * ratio / (1 + ratio)
    t_roll = np.linalg.norm(slip) * ratio / (1 + ratio) / (friction * g)
    steps = round(1.5 * t_roll / (dt * stage.dt_factor))
    for _ in range(steps):
        watch.step()
    t = world.time / stage.time
    v = stage.velocity(body)
    w = stage.spin(body)
    moved = stage.position(world, body) - (0, 0, radius)
    exact = 0.5 * (v0 + v_roll) * t_roll + v_roll * (t - t_roll)
    return watch.report(
        velocity=float(np.linalg.norm(v - v_roll) / speed),
        slip=float(np.linalg.norm(v + np.cross(w, (0, 0, -radius))) / speed),
        distance=float(np.linalg.norm(moved - exact) / np.linalg.norm(exact)),
    )


# ---- stacks -------------------------------------------------------------------------------------


def tower(
    stage: Stage,
    boxes: int = 10,
    dt: float = 5e-3,
    seconds: float = 10.0,
    masses=None,
    friction: float = 0.5,
    half=(0.1, 0.1, 0.1),
    on_box: bool = False,
) -> dict[str, float]:
    """Stands; every interface carries the weight above it, every step, its corners evenly."""
    masses = np.ones(boxes) if masses is None else np.asarray(masses, float)
    half = np.asarray(half, float)
    world = stage.world(dt)
    if on_box:
        stage.fixed_box(world, (1.0, 1.0, 0.5), (0, 0, -0.5), friction=friction)
    else:
        stage.plane(world, friction=friction)
    tower = [
        stage.add(world, stage.box(half), m, (0, 0, (2 * k + 1) * half[2]), friction=friction)
        for k, m in enumerate(masses)
    ]
    above = g * np.cumsum(masses[::-1])[::-1]  # N, weight an interface carries
    watch = Watch(world)
    penetration = force_error = uneven = jitter = motion = net = 0.0
    last = None
    for _ in range(round(seconds / (dt * stage.dt_factor))):
        watch.step()
        z = np.array([stage.position(world, body)[2] for body in tower])
        gaps = np.diff(np.concatenate([[-half[2]], z])) - 2 * half[2]
        penetration = max(penetration, -gaps.min())
        contacts = world.contacts
        forces = stage.force(contacts["force"])
        # A box is row k + 1 and body A of the interface below it.
        sums = np.zeros((boxes, 3))
        np.add.at(sums, contacts["body_a"] - 1, forces)
        force_error = max(force_error, np.abs(sums[:, 2] / above - 1).max())
        corners = above[contacts["body_a"] - 1] / 4
        uneven = max(uneven, np.abs(forces[:, 2] / corners - 1).max())
        if last is not None and last.shape == forces.shape:
            jitter = max(jitter, np.abs(forces - last).max())
        last = forces
        for body, m in zip(tower, masses, strict=True):
            force = stage.force(body.contact_wrench[0])
            net = max(net, np.abs(force - (0, 0, m * g)).max() / above[0])
            motion = max(motion, np.linalg.norm(stage.velocity(body)))
    return watch.report(
        **{
            "penetration (m)": float(penetration),
            "force sum": float(max(force_error, net)),
            "corners": float(uneven),
            "jitter (N)": float(jitter),
            "motion (m/s)": float(motion),
        }
    )


def groove_normals(angle: float, heading: float = 0.0):
    """Normals of two walls, ``angle`` from the vertical each, facing each other."""
    R = rotation(turn((0, 0, 1), heading))
    return R @ (np.sin(angle), 0, np.cos(angle)), R @ (-np.sin(angle), 0, np.cos(angle))


def sphere_in_groove(
    stage: Stage,
    angle: float = np.pi / 4,
    friction: float = 0.0,
    dt: float = 1e-3,
    steps: int = 500,
    heading: float = 0.0,
) -> dict[str, float]:
    """N = m g / (2 cos phi) on each wall, without friction."""
    radius = 0.1
    world = stage.world(dt)
    for n in groove_normals(angle, heading):
        stage.plane(world, n, friction=friction)
    position = np.array([0, 0, radius / np.cos(angle)])
    ball = stage.add(world, stage.sphere(radius), 1.0, position, friction=friction)
    return _groove_forces(stage, world, ball, position, angle, friction, steps, per_wall=1)


def box_in_groove(
    stage: Stage,
    friction: float = 0.0,
    dt: float = 1e-3,
    steps: int = 500,
    heading: float = 0.0,
    angle: float = np.pi / 4,
) -> dict[str, float]:
    """On its faces (phi = 45 deg) or, at other angles, flat on its two lower edges.

    Without friction N = m g / (2 cos phi); with mu <= tan phi the least forces have
    N = m g / (2 (cos phi + mu sin phi)), friction fully used."""
    world = stage.world(dt)
    for n in groove_normals(angle, heading):
        stage.plane(world, n, friction=friction)
    around = turn((0, 0, 1), heading)
    if angle == np.pi / 4:
        half = np.array([0.1, 0.15, 0.1])
        q = multiply(around, turn((0, 1, 0), np.pi / 4))
        position = np.array([0, 0, half[0] * np.sqrt(2)])
    else:
        half = np.array([0.1, 0.15, 0.02])  # flat: it sits below the point its walls turn it about
        q = around
        position = np.array([0, 0, half[0] * np.tan(angle) + half[2]])
    box = stage.add(world, stage.box(half), 1.0, position, q, friction=friction)
    per_wall = 4 if angle == np.pi / 4 else 2
    return _groove_forces(stage, world, box, position, angle, friction, steps, per_wall)


def _groove_forces(stage, world, body, position, angle, friction, steps, per_wall):
    mu = min(friction, np.tan(angle))
    exact = g / (2 * (np.cos(angle) + mu * np.sin(angle)))
    watch = Watch(world)
    error = uneven = balance = cone = mirror = moved = 0.0
    for _ in range(steps):
        watch.step()
        contacts = world.contacts
        forces = stage.force(contacts["force"])
        normals = contacts["normal"] @ stage.matrix
        along = np.einsum("ij,ij->i", forces, normals)
        tangential = np.linalg.norm(forces - along[:, None] * normals, axis=1)
        walls = contacts["body_b"]
        sums = [along[walls == w].sum() for w in (0, 1)]
        error = max(error, abs(sums[0] / exact - 1), abs(sums[1] / exact - 1))
        mirror = max(mirror, abs(sums[0] - sums[1]) / exact)
        balance = max(balance, np.linalg.norm(forces.sum(axis=0) - (0, 0, g)) / g)
        cone = max(cone, (tangential - friction * along).max() / exact)
        carried = along[along > 0]
        if len(carried) == 2 * per_wall:
            uneven = max(uneven, np.abs(carried * per_wall / exact - 1).max())
        moved = max(moved, np.linalg.norm(stage.position(world, body) - position))
    return watch.report(
        **{
            "N": float(error),
            "mirror": float(mirror),
            "balance": float(balance),
            "outside the cone": float(cone),
            "corners": float(uneven),
            "moved (m)": float(moved),
        }
    )


def heap_of_balls(
    stage: Stage, dt: float = 1e-2, seconds: float = 10.0, side: int = 6, stagger: float = 0.0
) -> dict[str, float]:
    """The 666 test: balls in a cubic grid fall on a floor, no friction, no rebound; the squared
    penetration of all pairs and of the floor, summed, mean over all steps (m²).

    ``stagger`` moves each layer sideways, so that the columns fall apart at once."""
    radius, gap = 0.5, 0.1
    world = stage.world(dt)
    stage.plane(world, friction=0.0)
    rng = np.random.default_rng(666)
    balls = []
    for k in range(side):
        for j in range(side):
            for i in range(side):
                x = np.array([i, j, k]) * (2 * radius + gap) + (0, 0, radius + gap)
                x[:2] += stagger * rng.uniform(-1, 1, 2)
                balls.append(stage.add(world, stage.sphere(radius), 1.0, x, friction=0.0))
    i, j = np.triu_indices(len(balls), 1)
    steps = round(seconds / (dt * stage.dt_factor))
    watch = Watch(world)
    total = worst = 0.0
    for _ in range(steps):
        watch.step()
        x = (world.positions[1:] - stage.origin) @ stage.matrix / stage.size
        floor = np.maximum(radius - x[:, 2], 0)
        pairs = np.maximum(2 * radius - np.linalg.norm(x[i] - x[j], axis=1), 0)
        total += (floor**2).sum() + (pairs**2).sum()
        worst = max(worst, floor.max(), pairs.max())
    return watch.report(
        **{"squared penetration (m²)": float(total / steps), "deepest (m)": float(worst)}
    )
