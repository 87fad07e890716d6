"""What is simulated, in plain numbers that every engine can be given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Ball:
    """Sphere of ``radius`` m."""

    radius: float

    @property
    def volume(self) -> float:
        """m³."""
        return 4 / 3 * np.pi * self.radius**3

    @property
    def principal_inertia(self) -> np.ndarray:
        """(3,) m², moments of inertia of unit mass."""
        return np.full(3, 0.4 * self.radius**2)


@dataclass(frozen=True)
class Block:
    """Box; ``half`` are its half extents in m."""

    half: tuple[float, float, float]

    @property
    def volume(self) -> float:
        """m³."""
        return float(8 * np.prod(self.half))

    @property
    def principal_inertia(self) -> np.ndarray:
        """(3,) m², moments of inertia of unit mass."""
        sq = np.square(self.half)
        return (sq.sum() - sq) / 3


@dataclass(frozen=True)
class Hull:
    """Convex hull of vertices (m) that lie symmetrically about the axes, so that the centre of mass is
    the origin and the axes are principal. ``volume`` in m³ and ``principal_inertia`` in m² are exact."""

    vertices: tuple[tuple[float, float, float], ...]
    volume: float
    principal_inertia: tuple[float, float, float]


Shape = Ball | Block | Hull


@dataclass(frozen=True)
class Item:
    """A body: dynamic, of 1000 kg/m³, or kinematic with a constant ``velocity`` (m/s)."""

    shape: Shape
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)  # x y z w
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    kinematic: bool = False

    @property
    def mass(self) -> float:
        """kg."""
        return 1000.0 * self.shape.volume


@dataclass(frozen=True)
class Plane:
    """Everything with normal·x < offset is solid."""

    normal: tuple[float, float, float]
    offset: float


GROUND = Plane((0.0, 0.0, 1.0), 0.0)


@dataclass(frozen=True)
class Scene:
    """``from_python``: each step is one call that also applies a force and reads all poses, as a control
    loop does; else steps are made as fast as the engine's interface allows."""

    name: str
    items: Sequence[Item]
    dt: float  # s
    warm_up: int  # steps before the clock runs
    blocks: int  # times that are taken
    block: int  # steps per time
    planes: Sequence[Plane] = field(default=(GROUND,))
    friction: float = 0.5
    restitution: float = 0.0
    from_python: bool = False
    call_only: bool = False  # one call of step() each, nothing else
    tower: bool = False  # stands when the top is where it was
    squared: bool = False  # also the sum of squared penetrations
    group: str = ""


def plane_frame(plane: Plane) -> np.ndarray:
    """(3, 3) rotation whose last column is the normal, for engines whose planes face an axis."""
    n = np.asarray(plane.normal, float)
    t = np.cross([0.0, 1.0, 0.0] if abs(n[1]) < 0.9 else [1.0, 0.0, 0.0], n)
    t /= np.linalg.norm(t)
    return np.stack([t, np.cross(n, t), n], axis=1)


def quaternion(matrix: np.ndarray) -> np.ndarray:
    """Unit quaternion x y z w of a rotation matrix."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m.trace()],
        ]
    )
    return np.linalg.eigh(k / 3, UPLO="L")[1][:, -1]
