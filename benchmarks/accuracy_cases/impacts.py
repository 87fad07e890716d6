"""Balls that bounce, strike one another, and bounce obliquely on a rough floor."""

from __future__ import annotations

import numpy as np

from ..stage import GRAVITY as g
from ..stage import Stage
from .watch import Watch


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
