"""Where a case is played: the same scene at another size, mass, place, attitude or speed.

Cases are written in plain numbers (z up, metres, kilograms). A stage maps them: lengths times
``size``, masses times ``mass``, and times and speeds so that the motion stays similar under the
same gravity (time with the root of the length); then it turns, shifts and boosts everything,
gravity, ground and kinematic bodies included.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import rb_physics as rb

GRAVITY = 9.81


def multiply(p, q):
    """Hamilton product of quaternions x y z w."""
    v, w = np.asarray(p[:3]), p[3]
    u, s = np.asarray(q[:3]), q[3]
    return np.append(w * u + s * v + np.cross(v, u), w * s - v @ u)


def rotation(q) -> np.ndarray:
    """Rotation matrix of a unit quaternion x y z w."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turn(axis, angle) -> np.ndarray:
    """Unit quaternion of the rotation by ``angle`` (rad) about ``axis``."""
    axis = np.asarray(axis, float)
    return np.append(np.sin(angle / 2) * axis / np.linalg.norm(axis), np.cos(angle / 2))


def angle_between(p, q) -> float:
    """rad, rotation from one attitude to the other."""
    p, q = np.asarray(p), np.asarray(q)
    return float(4 * np.arcsin(0.5 * min(np.linalg.norm(p - q), np.linalg.norm(p + q))))


@dataclass(frozen=True)
class Stage:
    """One way to play a case; the default is the case as it is written."""

    stepper: str = "fixed"
    impact_law: str = "simultaneous"
    dt_factor: float = 1.0
    size: float = 1.0
    mass: float = 1.0
    attitude: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m, after scaling
    boost: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m/s, after scaling
    settings: dict[str, Any] = field(default_factory=dict)

    # ---- scales -----------------------------------------------------------------------------
    @property
    def time(self) -> float:
        return float(np.sqrt(self.size))

    @property
    def speed(self) -> float:
        return float(np.sqrt(self.size))

    @property
    def matrix(self) -> np.ndarray:
        return rotation(self.attitude)

    def dt(self, dt: float) -> float:
        return dt * self.dt_factor * self.time

    # ---- making -----------------------------------------------------------------------------
    def world(self, dt: float, gravity=(0.0, 0.0, -GRAVITY), **settings: Any) -> rb.World:
        return rb.World(
            gravity=self.matrix @ gravity,
            dt=self.dt(dt),
            **{"stepper": self.stepper, "impact_law": self.impact_law, **settings, **self.settings},
        )

    def plane(self, world: rb.World, normal=(0.0, 0.0, 1.0), offset=0.0, **more: Any) -> rb.Body:
        """A half-space n . x <= offset. Boosted stages drive it with the boost."""
        n = np.asarray(normal, float) / np.linalg.norm(normal)
        shape = rb.HalfSpace(normal=self.matrix @ n, offset=offset * self.size)
        return self._fixed(world, shape, np.array(self.origin), (0, 0, 0, 1), **more)

    def fixed_box(
        self, world: rb.World, half, position, orientation=(0, 0, 0, 1), **more: Any
    ) -> rb.Body:
        """A box that does not move (but for the boost)."""
        shape = rb.Box(np.asarray(half) * self.size)
        q = multiply(self.attitude, orientation)
        return self._fixed(world, shape, self.point(position), q, **more)

    def _fixed(self, world, shape, position, orientation, **more):
        still = not np.any(self.boost)
        return world.add_body(
            shape,
            type="static" if still else "kinematic",
            position=position,
            orientation=orientation,
            **({} if still else {"linear_velocity": self.boost}),
            **more,
        )

    def add(
        self,
        world: rb.World,
        shape: Any,
        mass: float | None = None,
        position=(0.0, 0.0, 0.0),
        orientation=(0.0, 0.0, 0.0, 1.0),
        velocity=(0.0, 0.0, 0.0),
        spin=(0.0, 0.0, 0.0),
        inertia=None,
        **more: Any,
    ) -> rb.Body:
        """A body given in the plain numbers of the case; its shape must already be scaled."""
        if mass is not None:
            more["mass"] = mass * self.mass
        if inertia is not None:
            more["inertia"] = np.asarray(inertia) * self.mass * self.size**2
        return world.add_body(
            shape,
            position=self.point(position),
            orientation=multiply(self.attitude, orientation),
            linear_velocity=self.vector(velocity) * self.speed + self.boost,
            angular_velocity=self.vector(spin) / self.time,
            **more,
        )

    def sphere(self, radius: float) -> Any:
        return rb.Sphere(radius * self.size)

    def box(self, half) -> Any:
        return rb.Box(np.asarray(half, float) * self.size)

    # ---- maps -------------------------------------------------------------------------------
    def vector(self, v) -> np.ndarray:
        return self.matrix @ np.asarray(v, float)

    def point(self, x) -> np.ndarray:
        return self.matrix @ np.asarray(x, float) * self.size + self.origin

    # Back to the plain numbers of the case.
    def position(self, world: rb.World, body: rb.Body) -> np.ndarray:
        moved = np.asarray(self.origin) + np.asarray(self.boost) * world.time
        return self.matrix.T @ (body.com_position - moved) / self.size

    def velocity(self, body: rb.Body) -> np.ndarray:
        return self.matrix.T @ (body.linear_velocity - np.asarray(self.boost)) / self.speed

    def spin(self, body: rb.Body) -> np.ndarray:
        return self.matrix.T @ body.angular_velocity * self.time

    def force(self, force) -> np.ndarray:
        """Forces in the units of the case (the same accelerations, masses times ``mass``)."""
        return np.asarray(force) @ self.matrix / self.mass
