"""Towers and a heap of balls: what stands, and carries the weight above."""

from __future__ import annotations

import numpy as np

from ..stage import GRAVITY as g
from ..stage import Stage
from .watch import Watch


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
