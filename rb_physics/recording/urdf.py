"""The scene as URDF: one floating link per body, so that /tf moves them in any viewer.

Source: the URDF specification, http://wiki.ros.org/urdf/XML; angles of a quaternion after
Bernardes & Viollet, "Quaternion to Euler angles conversion", PLoS ONE 17(11), 2022.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription, Part
from .palette import body_colors, typical_radius
from .quaternions import rotate

_PLANE_SIZE = 40.0  # in typical body radii


def scene_urdf(bodies: Sequence[BodyDescription], name: str = "scene") -> str:
    """URDF text.

    A link has `visual` for all that URDF can draw (not for meshes, which it takes from files only),
    `inertial` when the body is dynamic, and `collision` when URDF has a geometry for the whole of
    its shape: half-spaces, meshes and hulls, height fields and particles have none.
    """
    lines = [f"<robot name={quoteattr(name)}>", ' <link name="world"/>']
    width = _PLANE_SIZE * typical_radius(bodies)
    for body, color in zip(bodies, body_colors(bodies), strict=True):
        label = quoteattr(body.name)
        rgba = " ".join(f"{c / 255:.3f}" for c in color)
        material = quoteattr(f"{body.name}_color")
        lines += [f" <link name={label}>", *_inertial(body)]
        drawn = [
            f"{_origin(part.orientation, at)}<geometry>{geometry}</geometry>"
            for part in body.parts
            for geometry, at in _geometries(part, width)
        ]
        lines += [
            f'  <visual>{shape}<material name={material}><color rgba="{rgba}"/></material></visual>'
            for shape in drawn
        ]
        if _solid(body):
            lines += [f"  <collision>{shape}</collision>" for shape in drawn]
        lines.append(" </link>")
        joint = quoteattr(f"{body.name}_joint")
        lines.append(
            f' <joint name={joint} type="floating"><parent link="world"/><child link={label}/>'
            "</joint>"
        )
    return "\n".join([*lines, "</robot>", ""])


def _inertial(body: BodyDescription) -> list[str]:
    if body.type != "dynamic" or body.inertia is None:
        return []
    entries = np.array(body.inertia).reshape(3, 3)
    inertia = " ".join(
        f'i{"xyz"[row]}{"xyz"[column]}="{_number(entries[row, column])}"'
        for row in range(3)
        for column in range(row, 3)
    )
    at = " ".join(map(_number, body.center_of_mass))
    return [
        f'  <inertial><origin xyz="{at}"/><mass value="{_number(body.mass)}"/><inertia {inertia}/>'
        "</inertial>"
    ]


def _solid(body: BodyDescription) -> bool:
    """Whether the geometries of URDF make up the whole shape."""
    point = body.type == "dynamic" and body.inertia is not None and not any(body.inertia)
    return not point and all(part.kind not in ("plane", "mesh") for part in body.parts)


def _number(value: float) -> str:
    """The shortest text that reads as the same double."""
    return repr(float(value)).removesuffix(".0")


def _geometries(part: Part, width: float) -> list[tuple[str, NDArray]]:
    """Elements that make up a part, and where the centre of each is in the axes of the body, m."""
    out = rotate(np.array([part.orientation]), np.array([[0.0, 0.0, 1.0]]))[0]
    center = np.asarray(part.position, np.float64)

    def sphere(radius: float) -> str:
        return f'<sphere radius="{_number(radius)}"/>'

    if part.kind == "sphere":
        return [(sphere(part.size[0]), center)]
    if part.kind == "box":
        size = " ".join(_number(2 * h) for h in part.size)
        return [(f'<box size="{size}"/>', center)]
    if part.kind == "plane":
        thick = 1e-3 * width
        return [(f'<box size="{width:.6g} {width:.6g} {thick:.6g}"/>', center - thick / 2 * out)]
    if part.kind == "mesh":
        return []
    radius, half_length = part.size
    tube = f'<cylinder radius="{_number(radius)}" length="{_number(2 * half_length)}"/>'
    if part.kind == "cylinder":
        return [(tube, center)]
    ends = [(sphere(radius), center + side * half_length * out) for side in (1, -1)]
    return [(tube, center), *ends]


def _origin(orientation: Sequence[float], position: NDArray) -> str:
    """Position, m, and the angles about the fixed axes x, y, z, rad; exact where y is a right one, too."""
    x, y, z, w = orientation
    half_sum, half_difference = math.atan2(x + z, w - y), math.atan2(z - x, w + y)
    pitch = 2 * math.atan2(math.hypot(w + y, z - x), math.hypot(w - y, x + z)) - math.pi / 2
    angles = (half_sum - half_difference, pitch, half_sum + half_difference)
    xyz, rpy = (" ".join(map(_number, values)) for values in (position, angles))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'
