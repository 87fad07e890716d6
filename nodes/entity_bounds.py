"""Which bodies touch given Bounds of simulation_interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import rb_physics as rb
from rb_physics.errors import SceneError

_ORIGIN = (0.0, 0.0, 0.0)


def probe_of(bounds: Any) -> tuple[Any, tuple[float, ...]]:
    """Shape and position in the world of Bounds. Raises ValueError for points that make none."""
    points = np.array([(p.x, p.y, p.z) for p in bounds.points], float).reshape(-1, 3)
    if not np.isfinite(points).all():
        raise ValueError("bounds must be finite")
    if bounds.type in (bounds.TYPE_BOX, bounds.TYPE_SPHERE) and len(points) != 2:
        raise ValueError(f"bounds of this type have 2 points, not {len(points)}")
    try:
        if bounds.type == bounds.TYPE_BOX:
            half = np.abs(points[0] - points[1]) / 2
            return rb.Box(half_extents=half), tuple((points[0] + points[1]) / 2)
        if bounds.type == bounds.TYPE_SPHERE:
            return rb.Sphere(radius=points[1, 0]), tuple(points[0])
        if bounds.type == bounds.TYPE_CONVEX_HULL:
            return rb.ConvexHull(points), _ORIGIN
    except SceneError as error:
        raise ValueError(f"bounds are no body: {error}") from None
    raise ValueError(f"bounds have the unknown type {bounds.type}")


def overlapping(bodies: Sequence[Any], bounds: Any) -> list[str]:
    """Names of the bodies that touch or overlap `bounds`. Raises ValueError as `probe_of` does."""
    shape, position = probe_of(bounds)
    scratch = rb.World()
    probe = scratch.add_body(shape, type="kinematic", name="probe", position=position)
    found = []
    for body in bodies:
        twin = scratch.add_body(
            body.shape, type="static", name=f"{body.name}_",
            position=body.position, orientation=body.orientation,
        )  # fmt: skip
        if rb.test_intersection(probe, twin):
            found.append(body.name)
    return found
