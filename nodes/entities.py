"""Entities of simulation_interfaces: bodies spawned from text or a file, their states, deletion."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlparse

import numpy as np

from rb_physics import checks
from rb_physics import math as rotations
from rb_physics.errors import SceneError
from rb_physics.recording import TopicError
from rb_physics.scene import parse_body

from .frames import Pose, compose, frame_pose
from .kinematic_inputs import UNIT_TOLERANCE
from .urdf_body import UrdfError, body_from_urdf, is_urdf
from .wrench_inputs import Perform

FORMATS = ["rb_physics_yaml", "urdf"]  # a body as in a scene file, or as URDF


class EntityError(ValueError):
    """A request that can't be met; `result` names the constant of the response or of Result."""

    def __init__(self, result: str, text: str) -> None:
        super().__init__(text)
        self.result = result


def description(request: Any) -> dict[str, Any]:
    """The body that a SpawnEntity request describes. Raises EntityError."""
    if request.entity_namespace:
        raise EntityError(
            "NAMESPACE_INVALID",
            f"entity_namespace is '{request.entity_namespace}', but bodies have their topics below "
            "the simulator's name: leave it empty",
        )
    text, source = request.resource_string, "resource_string"
    if bool(text) == bool(request.uri):
        given = "neither" if not text else "both"
        raise EntityError("NO_RESOURCE", f"{given} of uri and resource_string given; give one")
    if not text:
        text, source = _read(request.uri), request.uri
    try:
        if not is_urdf(text):
            return parse_body(text, source, name=request.name or None)
        folder = _path(request.uri).parent if request.uri else Path("/")
        body = body_from_urdf(text, source, folder)
        return {**body, "name": checks.name(request.name or body["name"], "body")}
    except UrdfError as error:
        raise EntityError(error.code, str(error)) from None
    except SceneError as error:
        code = "NAME_INVALID" if "name" in str(error.field) else "RESOURCE_PARSE_ERROR"
        raise EntityError(code, str(error)) from None


def _read(uri: str) -> str:
    parsed = urlparse(uri)
    if parsed.scheme not in ("", "file"):
        raise EntityError("NO_RESOURCE", f"uri is '{uri}'; only paths and file: are read")
    try:
        return _path(uri).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise EntityError("NO_RESOURCE", f"uri '{uri}' can't be read: {error}") from None


def _path(uri: str) -> Path:
    return Path(unquote(urlparse(uri).path))


def spawn(world: Any, body: dict[str, Any], request: Any, perform: Perform) -> str:
    """Add a body at `initial_pose`; a pose of its own counts from there. Returns its name.

    In the physics thread. Raises EntityError.
    """
    name = str(body["name"])
    if name in world:
        if not request.allow_renaming:
            known = ", ".join(each.name for each in world.bodies)
            raise EntityError("NAME_NOT_UNIQUE", f"'{name}' is taken; there are {known}")
        number = 1
        while f"{name}_{number}" in world:
            number += 1
        name = f"{name}_{number}"
    asked = _pose(request.initial_pose.pose, f"initial_pose of '{name}'")
    try:
        frame = frame_pose(world, request.initial_pose.header.frame_id)
    except ValueError as error:
        raise EntityError("INVALID_POSE", str(error)) from None
    own = (
        np.array(body.get("position", (0, 0, 0)), float),
        np.array(body.get("orientation", (0, 0, 0, 1)), float),
    )
    position, orientation = compose(compose(frame, asked), own)
    placed = {**body, "name": name, "position": position, "orientation": orientation}
    try:
        perform("add_body", description=placed)
    except TopicError as error:
        raise EntityError("NAME_INVALID", str(error)) from None
    except SceneError as error:
        raise EntityError("RESOURCE_PARSE_ERROR", str(error)) from None
    return name


def _pose(pose: Any, what: str) -> Pose:
    p, q = pose.position, pose.orientation
    position, orientation = np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w])
    norm = math.sqrt(float(orientation @ orientation))
    if not np.isfinite(position).all() or not abs(norm - 1.0) <= UNIT_TOLERANCE:
        raise EntityError(
            "INVALID_POSE",
            f"{what} must be finite and its quaternion of length 1, which is {norm:g}",
        )
    return position, orientation / norm


def set_state(world: Any, name: str, state: Any, perform: Perform) -> None:
    """Give a body a state, whose twist is that of the origin of its frame. Raises EntityError."""
    body = world[name]
    if body.type == "static" and _moves(state.twist):
        raise EntityError("RESULT_OPERATION_FAILED", f"body '{name}' is static: it has no twist")
    try:
        frame = frame_pose(world, state.header.frame_id)
    except ValueError as error:
        raise EntityError("RESULT_OPERATION_FAILED", str(error)) from None
    position, orientation = compose(frame, _pose(state.pose, f"state of '{name}'"))
    twist = [[v.x, v.y, v.z] for v in (state.twist.linear, state.twist.angular)]
    if not np.isfinite(twist).all():
        raise EntityError("INVALID_POSE", f"the twist of '{name}' must be finite")
    linear, angular = (rotations.rotate(frame[1], np.array(v)) for v in twist)
    acceleration = getattr(state, "acceleration", None)
    if acceleration is not None and _moves(acceleration):
        raise EntityError(
            "RESULT_OPERATION_FAILED",
            f"acceleration of '{name}' can't be set: forces decide on it; leave it 0",
        )
    velocities = {}
    if body.type != "static":
        lever = rotations.rotate(orientation, np.array(body.center_of_mass))
        velocities["linear_velocity"] = linear + np.cross(angular, lever)
        velocities["angular_velocity"] = angular
    perform("change_body", body=name, position=position, orientation=orientation, **velocities)


def _moves(twist: Any) -> bool:
    return any(getattr(v, axis) != 0.0 for v in (twist.linear, twist.angular) for axis in "xyz")


def get_state(world: Any, name: str, state: Any) -> None:
    """Fill in the state of a body: in the world, its twist that of the origin of its frame."""
    body = world[name]
    state.header.frame_id = "world"
    sec, nanosec = divmod(round(world.time * 1e9), 10**9)
    state.header.stamp.sec, state.header.stamp.nanosec = sec, nanosec
    spin = np.array(body.angular_velocity)
    lever = np.array(body.position) - np.array(body.com_position)
    velocity = np.array(body.linear_velocity) + np.cross(spin, lever)
    for vector, values in (
        (state.pose.position, body.position),
        (state.twist.linear, velocity),
        (state.twist.angular, spin),
    ):
        vector.x, vector.y, vector.z = (float(value) for value in values)
    q = state.pose.orientation
    q.x, q.y, q.z, q.w = (float(value) for value in body.orientation)
