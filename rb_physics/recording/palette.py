"""Colours and scales shared by markers, URDF and the Rerun view."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .geometry import BodyDescription

RGBA = tuple[int, int, int, int]

STATIC: RGBA = (150, 155, 160, 255)
KINEMATIC: RGBA = (235, 190, 60, 255)
FORCE: RGBA = (225, 50, 45, 255)  # of contacts
APPLIED: RGBA = (30, 105, 220, 255)  # forces applied from outside
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


def force_scale(bodies: Sequence[BodyDescription], gravity: float) -> float:
    """m of arrow per N: the weight of the median body gives an arrow twice its radius."""
    masses = [b.mass for b in bodies if b.mass > 0]
    weight = float(np.median(masses)) * (gravity or 9.81) if masses else 9.81
    return 2.0 * typical_radius(bodies) / weight
