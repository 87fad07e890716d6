"""What the benchmark asks of an engine."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .scene import Scene


class Engine(Protocol):
    """Built from a scene; sleeping, damping and continuous collision off, all else at its defaults."""

    name: str
    precision: str  # "f32" or "f64"

    def __init__(self, scene: Scene) -> None: ...

    @staticmethod
    def version() -> str: ...

    def step(self, count: int) -> None:
        """Makes ``count`` steps; kinematic bodies keep their velocities."""

    def step_once(self) -> None:
        """One step by the shortest call the interface has."""

    def push(self, force: np.ndarray) -> None:
        """Force (N) on the first body's centre of mass, world axes, for the next step."""

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (N, 3) in m and orientations (N, 4), x y z w."""
