"""A box on an incline and on the level, a ball that comes to roll."""

from __future__ import annotations

import numpy as np

from ..stage import GRAVITY as g
from ..stage import Stage, multiply, rotation, turn
from .watch import Watch


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
