"""A body from URDF: one link, or several held together by fixed joints.

Taken are mass, centre of mass and inertia of `inertial`, and the shapes of `collision`; the body
frame is that of the root link. A link `world` at the root stands for the world: the body hangs on
it by a floating joint, or by a fixed one, which makes it static. Everything else in the text
(pictures, transmissions, extensions of other simulators) says nothing about a rigid body.

Source: the URDF specification, http://wiki.ros.org/urdf/XML
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from rb_physics import math as rotations
from rb_physics.errors import SceneError
from rb_physics.mesh_file import inline_mesh

from .frames import Pose, compose
from .wrench_frames import WORLD

_IDENTITY: Pose = (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))
_INERTIA = ("ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz")


class UrdfError(ValueError):
    """Text that describes no rigid body; `code` is the constant of SpawnEntity that says why."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class _Joint(NamedTuple):
    name: str
    kind: str
    parent: str
    child: str
    pose: Pose


def is_urdf(text: str) -> bool:
    """Whether a description is XML; the other ones are YAML."""
    return text.lstrip().startswith("<")


def body_from_urdf(text: str, source: str, folder: Path | None = None) -> dict[str, Any]:
    """The body as in a scene file; its name is that of the robot.

    Args:
        source: what error messages call the text.
        folder: where relative mesh files start; None allows no mesh files.

    Raises UrdfError.
    """
    robot = _parsed(text, source)
    links = {_name(link, source): link for link in robot.iter("link")}
    joints = [_joint(joint, links, source) for joint in robot.findall("joint")]
    root, placed, static = _root(links, joints, source)
    parts: list[dict[str, Any]] = []
    masses: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = []
    for name, pose in _rigid(root, joints, source):
        link = links[name]
        parts += _shapes(link, pose, f"{source}: link '{name}'", folder)
        masses += _masses(link, pose, f"{source}: link '{name}'")
    if not parts:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"{source}: no link has a collision geometry")
    body: dict[str, Any] = {"name": robot.get("name", ""), "shape": _joined(parts)}
    if placed is not _IDENTITY:
        body |= {"position": placed[0].tolist(), "orientation": placed[1].tolist()}
    if static:
        return {**body, "type": "static"}
    if not masses:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"{source}: no link has an inertial mass")
    return body | _mass_properties(masses)


def _parsed(text: str, source: str) -> ElementTree.Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise UrdfError(
            "RESOURCE_PARSE_ERROR", f"{source} declares a document type; leave that out"
        )
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"{source} is not valid XML: {error}") from None
    if robot.tag != "robot":
        raise UrdfError(
            "UNSUPPORTED_FORMAT",
            f"{source} is XML with the root <{robot.tag}>; of XML only URDF, <robot>, is read",
        )
    return robot


def _name(element: ElementTree.Element, source: str) -> str:
    name = element.get("name")
    if not name:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"{source}: a {element.tag} has no name")
    return name


def _joint(joint: ElementTree.Element, links: dict[str, Any], source: str) -> _Joint:
    name = _name(joint, source)
    ends = []
    for tag in ("parent", "child"):
        end = joint.find(tag)
        ends.append("" if end is None else end.get("link", ""))
        if ends[-1] not in links:
            raise UrdfError(
                "RESOURCE_PARSE_ERROR",
                f"{source}: {tag} of joint '{name}' is no link: '{ends[-1]}'",
            )
    pose = _pose(joint.find("origin"), f"{source}: joint '{name}'")
    return _Joint(name, joint.get("type", ""), ends[0], ends[1], pose)


def _root(links: dict[str, Any], joints: list[_Joint], source: str) -> tuple[str, Pose, bool]:
    """The root link of the body, its pose in the world, and whether it is fixed there."""
    children = {joint.child for joint in joints}
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        found = f"{', '.join(roots)} have" if roots else "no link has"
        raise UrdfError(
            "RESOURCE_PARSE_ERROR", f"{source}: {found} no parent; a body has one root link"
        )
    if roots[0] != WORLD:
        return roots[0], _IDENTITY, False
    hanging = [joint for joint in joints if joint.parent == WORLD]
    if len(hanging) != 1 or hanging[0].kind not in ("fixed", "floating"):
        raise UrdfError(
            "UNSUPPORTED_FORMAT",
            f"{source}: one body hangs on the link '{WORLD}' by a floating or a fixed joint, but "
            f"there are {', '.join(f'{j.name} ({j.kind})' for j in hanging) or 'none'}",
        )
    return hanging[0].child, hanging[0].pose, hanging[0].kind == "fixed"


def _rigid(root: str, joints: list[_Joint], source: str) -> Iterator[tuple[str, Pose]]:
    """The links that make up the body, with their poses in the root link."""
    waiting = [(root, _IDENTITY)]
    while waiting:
        name, pose = waiting.pop(0)
        yield name, pose
        for joint in joints:
            if joint.parent != name:
                continue
            if joint.kind != "fixed":
                raise UrdfError(
                    "UNSUPPORTED_FORMAT",
                    f"{source}: joint '{joint.name}' is {joint.kind or 'of no type'}; bodies are "
                    "rigid, so only fixed joints can be in one",
                )
            waiting.append((joint.child, compose(pose, joint.pose)))


def _shapes(
    link: ElementTree.Element, pose: Pose, where: str, folder: Path | None
) -> list[dict[str, Any]]:
    parts = []
    for collision in link.findall("collision"):
        geometry = collision.find("geometry")
        if geometry is None or len(geometry) != 1:
            raise UrdfError("RESOURCE_PARSE_ERROR", f"{where}: a collision needs one geometry")
        place = compose(pose, _pose(collision.find("origin"), where))
        shape = _shape(geometry[0], where, folder)
        parts.append(
            {"shape": shape, "position": place[0].tolist(), "orientation": place[1].tolist()}
        )
    return parts


def _shape(geometry: ElementTree.Element, where: str, folder: Path | None) -> dict[str, Any]:
    def number(key: str) -> float:
        return _numbers(geometry, key, 1, where)[0]

    if geometry.tag == "box":
        size = _numbers(geometry, "size", 3, where)
        return {"type": "box", "half_extents": [value / 2 for value in size]}
    if geometry.tag == "sphere":
        return {"type": "sphere", "radius": number("radius")}
    if geometry.tag in ("cylinder", "capsule"):
        half = number("length") / 2
        return {"type": geometry.tag, "radius": number("radius"), "half_length": half}
    if geometry.tag == "mesh":
        return _hull(geometry, where, folder)
    raise UrdfError(
        "UNSUPPORTED_ASSETS",
        f"{where}: geometry <{geometry.tag}>; known are box, sphere, cylinder, capsule and mesh",
    )


def _hull(geometry: ElementTree.Element, where: str, folder: Path | None) -> dict[str, Any]:
    """The convex hull of a mesh file: what moves is convex."""
    given = geometry.get("filename", "")
    parsed = urlparse(given)
    if parsed.scheme not in ("", "file"):
        raise UrdfError(
            "UNSUPPORTED_ASSETS", f"{where}: mesh '{given}'; only paths and file: are read"
        )
    scale = np.array(_numbers(geometry, "scale", 3, where) if geometry.get("scale") else [1.0] * 3)
    path = Path(unquote(parsed.path))
    if folder is None:
        raise UrdfError(
            "UNSUPPORTED_ASSETS",
            f"{where}: mesh '{given}' is a file; text from a topic or parameter can't name one",
        )
    try:
        hull = {"type": "convex_hull", "file": str(path), "scale": scale}
        return inline_mesh(hull, folder)
    except SceneError as error:
        missing = "does not exist" in str(error)
        code = "MISSING_ASSETS" if missing else "UNSUPPORTED_ASSETS"
        raise UrdfError(code, f"{where}: {error}") from None


def _joined(parts: list[dict[str, Any]]) -> dict[str, Any]:
    at_origin = parts[0]["position"] == [0.0] * 3 and parts[0]["orientation"] == [
        0.0,
        0.0,
        0.0,
        1.0,
    ]
    if len(parts) == 1 and at_origin:
        shape: dict[str, Any] = parts[0]["shape"]
        return shape
    return {"type": "compound", "parts": parts}


def _masses(
    link: ElementTree.Element, pose: Pose, where: str
) -> list[tuple[float, NDArray[np.float64], NDArray[np.float64]]]:
    """Mass (kg), centre of mass (m) and inertia about it (kg m²), in the axes of the root link."""
    inertial = link.find("inertial")
    if inertial is None:
        return []
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"{where}: inertial needs mass and inertia")
    center, turned = compose(pose, _pose(inertial.find("origin"), where))
    own = np.array([_numbers(inertia, key, 1, where)[0] for key in _INERTIA]).reshape(3, 3)
    axes = np.column_stack([rotations.rotate(turned, unit) for unit in np.eye(3)])
    return [(_numbers(mass, "value", 1, where)[0], center, axes @ own @ axes.T)]


def _mass_properties(
    masses: list[tuple[float, NDArray[np.float64], NDArray[np.float64]]],
) -> dict[str, Any]:
    """Of the links together, by the parallel axis theorem."""
    total = sum(mass for mass, _, _ in masses)
    if not total > 0.0:
        raise UrdfError("RESOURCE_PARSE_ERROR", f"the mass is {total:g} kg, but must be > 0")
    center = sum((mass * at for mass, at, _ in masses), np.zeros(3)) / total
    inertia = np.zeros((3, 3))
    for mass, at, own in masses:
        d = at - center
        inertia += own + mass * (float(d @ d) * np.eye(3) - np.outer(d, d))
    return {
        "mass": total,
        "center_of_mass": center.tolist(),
        "inertia": ((inertia + inertia.T) / 2).tolist(),
    }


def _pose(origin: ElementTree.Element | None, where: str) -> Pose:
    if origin is None:
        return _IDENTITY
    xyz = _numbers(origin, "xyz", 3, where) if origin.get("xyz") else [0.0] * 3
    rpy = _numbers(origin, "rpy", 3, where) if origin.get("rpy") else [0.0] * 3
    turned = _IDENTITY[1]
    for axis in (2, 1, 0):  # about x first, then y, then z, all fixed
        quaternion = np.zeros(4)
        quaternion[axis], quaternion[3] = math.sin(rpy[axis] / 2), math.cos(rpy[axis] / 2)
        turned = rotations.quaternion_multiply(turned, quaternion)
    return np.array(xyz), turned


def _numbers(element: ElementTree.Element, key: str, count: int, where: str) -> list[float]:
    text = element.get(key)
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise UrdfError(
            "RESOURCE_PARSE_ERROR",
            f"{where}: {key} of <{element.tag}> is {text!r}, but must be {count} finite "
            f"number{'s' if count > 1 else ''}",
        )
    return values
