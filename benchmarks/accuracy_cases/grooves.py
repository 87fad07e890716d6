"""A ball and a box in a V groove."""

from __future__ import annotations

import numpy as np

from ..stage import GRAVITY as g
from ..stage import Stage, multiply, rotation, turn
from .watch import Watch


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
