"""The scene as URDF: one floating link per body, so that /tf moves them in any viewer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

import numpy as np

from .geometry import BodyDescription, Part
from .palette import body_colors, typical_radius
from .quaternions import rotate

_PLANE_SIZE = 40.0  # in typical body radii


def scene_urdf(bodies: Sequence[BodyDescription], name: str = "scene") -> str:
    """URDF text. Meshes have no picture in it (URDF refers to mesh files only)."""
    lines = [f"<robot name={quoteattr(name)}>", ' <link name="world"/>']
    width = _PLANE_SIZE * typical_radius(bodies)
    for body, color in zip(bodies, body_colors(bodies), strict=True):
        label = quoteattr(body.name)
        rgba = " ".join(f"{c / 255:.3f}" for c in color)
        material = quoteattr(f"{body.name}_color")
        lines.append(f" <link name={label}>")
        for part in body.parts:
            for geometry, offset in _geometries(part, width):
                origin = _origin(part, offset)
                lines.append(
                    f"  <visual>{origin}<geometry>{geometry}</geometry>"
                    f'<material name={material}><color rgba="{rgba}"/></material></visual>'
                )
        lines.append(" </link>")
        joint = quoteattr(f"{body.name}_joint")
        lines.append(
            f' <joint name={joint} type="floating"><parent link="world"/><child link={label}/>'
            "</joint>"
        )
    return "\n".join([*lines, "</robot>", ""])


def _geometries(part: Part, width: float) -> list[tuple[str, tuple[float, float, float]]]:
    def sphere(radius: float) -> str:
        return f'<sphere radius="{radius:.9g}"/>'

    if part.kind == "sphere":
        return [(sphere(part.size[0]), (0, 0, 0))]
    if part.kind == "box":
        size = " ".join(f"{2 * h:.9g}" for h in part.size)
        return [(f'<box size="{size}"/>', (0, 0, 0))]
    if part.kind == "plane":
        thick = 1e-3 * width
        return [(f'<box size="{width:.6g} {width:.6g} {thick:.6g}"/>', (0, 0, -thick / 2))]
    if part.kind == "mesh":
        return []
    radius, half_length = part.size
    tube = f'<cylinder radius="{radius:.9g}" length="{2 * half_length:.9g}"/>'
    if part.kind == "cylinder":
        return [(tube, (0, 0, 0))]
    ends = [(sphere(radius), (0, 0, half_length)), (sphere(radius), (0, 0, -half_length))]
    return [(tube, (0, 0, 0)), *ends]


def _origin(part: Part, offset: tuple[float, float, float]) -> str:
    q = np.array([part.orientation])
    position = np.asarray(part.position) + rotate(q, np.array([offset], np.float64))[0]
    x, y, z, w = part.orientation
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    xyz = " ".join(f"{v:.9g}" for v in position)
    return f'<origin xyz="{xyz}" rpy="{roll:.9g} {pitch:.9g} {yaw:.9g}"/>'
