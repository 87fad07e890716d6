"""A free body that tumbles."""

from __future__ import annotations

import numpy as np

from ..free_rotation import attitude_of_free_rotation
from ..stage import Stage, angle_between, multiply, rotation


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
