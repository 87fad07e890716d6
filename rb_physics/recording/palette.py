"""Colours and scales shared by markers, URDF and the Rerun view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription

RGBA = tuple[int, int, int, int]

STATIC: RGBA = (150, 155, 160, 255)
KINEMATIC: RGBA = (235, 190, 60, 255)
FORCE: RGBA = (225, 50, 45, 255)  # of contacts
APPLIED: RGBA = (30, 105, 220, 255)  # forces applied from outside
APPLIED_TORQUE: RGBA = (120, 70, 200, 255)
# Of contact forces by the share of the friction cone they use, from 0 to 1 (about to slip, slipping).
CONE: tuple[RGBA, ...] = ((0, 135, 140, 255), (240, 165, 40, 255), FORCE)
# Muted, distinct also for the colour-blind, repeated in the order of the bodies.
DYNAMIC: tuple[RGBA, ...] = (
    (78, 121, 167, 255),
    (242, 142, 43, 255),
    (89, 161, 79, 255),
    (176, 122, 161, 255),
    (118, 183, 178, 255),
    (237, 201, 72, 255),
    (156, 117, 95, 255),
    (255, 157, 167, 255),
    (134, 188, 182, 255),
    (211, 114, 149, 255),
    (182, 153, 45, 255),
)


def body_colors(bodies: Sequence[BodyDescription]) -> list[RGBA]:
    """One colour per body."""
    colors: list[RGBA] = []
    count = 0
    for body in bodies:
        if body.type == "dynamic":
            colors.append(DYNAMIC[count % len(DYNAMIC)])
            count += 1
        else:
            colors.append(STATIC if body.type == "static" else KINEMATIC)
    return colors


def typical_radius(bodies: Sequence[BodyDescription]) -> float:
    """Median radius of the moving bodies, m; 0.1 when there are none."""
    radii = [b.radius for b in bodies if b.type != "static" and b.radius > 0]
    return float(np.median(radii)) if radii else 0.1


@dataclass(frozen=True)
class ForceArrows:
    """How long a force is drawn: `scale` m per N up to `knee` N, growing as its logarithm beyond.

    An impact within one step is easily a thousand times a weight; both should be seen.
    """

    scale: float
    knee: float

    @classmethod
    def of(cls, bodies: Sequence[BodyDescription], gravity: float) -> ForceArrows:
        """The weight of the median body is drawn twice its radius long; beyond begins the logarithm."""
        masses = [b.mass for b in bodies if b.mass > 0] or [1.0]
        weight = float(np.median(masses)) * (gravity or 9.81)
        return cls(2.0 * typical_radius(bodies) / weight, weight)

    def vectors(self, forces: NDArray) -> NDArray:
        """Arrows (N, 3) in m of forces (N, 3) in N."""
        sizes = np.sqrt(np.einsum("ij,ij->i", forces, forces))[:, None]
        excess = np.maximum(sizes / self.knee, 1.0)
        arrows: NDArray = forces * (self.scale * (1.0 + np.log(excess)) / excess)
        return arrows


def cone_colors(share: NDArray) -> NDArray:
    """RGBA (N, 4), uint8: CONE at shares (N,) of the friction cone; beyond 1 as at 1."""
    at = np.linspace(0.0, len(CONE) - 1.0, 256)
    stops = np.array(CONE, np.float64).T
    table = np.rint([np.interp(at, np.arange(len(CONE)), of) for of in stops]).astype(np.uint8).T
    colors: NDArray = table[(np.clip(share, 0.0, 1.0) * 255.0).astype(np.uint8)]
    return colors
