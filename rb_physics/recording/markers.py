"""visualization_msgs/msg/MarkerArray of bodies and contact-force arrows, for RViz and Foxglove."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .cdr import CdrWriter, Template, split_stamp
from .geometry import BodyDescription, Part
from .palette import FORCE, RGBA, ForceArrows, body_colors, typical_radius
from .quaternions import multiply, rotate

ARROW, CUBE, SPHERE, CYLINDER, TRIANGLE_LIST = 0, 1, 2, 3, 11
_ADD, _DELETE, _DELETE_ALL = 0, 2, 3
_PLANE_SIZE = 40.0  # in typical body radii: a half-space is drawn as a square this wide
_NAMESPACES = ("bodies", "contact_forces")
_IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def _marker(
    writer: CdrWriter,
    frame_id: str,
    namespace: str,
    identity: int,
    kind: int,
    scale: Sequence[float],
    color: RGBA,
    points: NDArray,
    text: str = "",
    action: int = _ADD,
) -> dict[str, int]:
    """Appends one Marker; returns where id and action lie."""
    writer.header(frame_id).string(namespace).i32(identity, kind)
    at = {"id": len(writer) - 8, "action": len(writer)}
    writer.i32(action)
    writer.doubles("poses", 7, _IDENTITY).f64(*scale).f32(*(c / 255 for c in color))
    writer.i32(0, 0).u8(0)  # lifetime: for ever; frame_locked
    writer.u32(len(points))
    writer.doubles("points", 3 * len(points), np.asarray(points, np.float64).reshape(-1).tolist())
    writer.u32(0)  # colors
    writer.string("").stamp().string("").string("").u32(0)  # texture_resource, empty texture
    writer.u32(0).string(text).string("")  # uv_coordinates, text, mesh_resource
    writer.string("").u32(0).u8(0)  # mesh_file, mesh_use_embedded_materials
    return at


class MarkerEncoder:
    """Bodies (namespace "bodies") and one arrow per contact force ("contact_forces").

    Forces of zero have no arrow; arrows of earlier messages are deleted when contacts go. `anew`: the
    bodies are others now, and the first message deletes all that was drawn before: in each
    namespace, as some viewers keep to the one that the deleting marker names.
    """

    def __init__(
        self,
        frame_id: str,
        bodies: Sequence[BodyDescription],
        arrows: ForceArrows,
        anew: bool = False,
    ) -> None:
        self._arrows = arrows
        self._anew = anew
        self._shaft = 0.08 * typical_radius(bodies)
        self._arrows_before = 0
        self._build_bodies(frame_id, bodies)
        self._build_arrow(frame_id)
        self._build_deletion(frame_id)

    def _build_bodies(self, frame_id: str, bodies: Sequence[BodyDescription]) -> None:
        writer = CdrWriter().u32(0)  # the count; arrows come between it and the bodies
        width = _PLANE_SIZE * typical_radius(bodies)
        rows, positions, orientations = [], [], []
        colors = body_colors(bodies)
        count = 0
        for row, body in enumerate(bodies):
            for part in body.parts:
                for kind, scale, offset in _primitives(part, width):
                    points = np.empty((0, 3))
                    if kind == TRIANGLE_LIST:
                        points = np.asarray(part.vertices)[np.asarray(part.triangles).reshape(-1)]
                    _marker(writer, frame_id, "bodies", count, kind, scale, colors[row], points)
                    q = np.array([part.orientation])
                    rows.append(row)
                    positions.append(np.asarray(part.position) + rotate(q, np.array([offset]))[0])
                    orientations.append(part.orientation)
                    count += 1
        self._body_count = count
        self._rows = np.array(rows, np.intp)
        self._positions = np.array(positions).reshape(-1, 3)
        self._orientations = np.array(orientations).reshape(-1, 4)
        writer.slots.setdefault("poses", [])
        self._bodies = Template(writer)
        self._poses = np.empty((count, 7))

    def _build_arrow(self, frame_id: str) -> None:
        """One arrow whose length is a multiple of 8, so that any number of them stays aligned."""
        for padding in range(8):
            writer = CdrWriter().u32(0)
            scale = (self._shaft, 2.2 * self._shaft, 0.0)
            text = "N" * padding
            at = _marker(
                writer, frame_id, "contact_forces", 0, ARROW, scale, FORCE, np.zeros((2, 3)), text
            )
            writer.align(4)  # where the next marker would start
            if (len(writer) - 8) % 8 == 0:
                break
        self._arrow = np.frombuffer(writer.tobytes(), np.uint8)[8:]
        self._id_at, self._action_at = at["id"] - 8, at["action"] - 8
        self._stamps_at = [offset + 4 - 8 for offset, _ in writer.slots["stamp"]]
        self._points_at = writer.slots["points"][0][0] + 4 - 8

    def _build_deletion(self, frame_id: str) -> None:
        """What deletes all in every namespace; padded, as an arrow is."""
        for padding in range(8):
            writer = CdrWriter().u32(0)
            for namespace in _NAMESPACES:
                _marker(
                    writer, frame_id, namespace, 0, ARROW, (1.0, 1.0, 1.0), FORCE,
                    np.empty((0, 3)), "N" * padding, _DELETE_ALL,
                )  # fmt: skip
                writer.align(4)
            if (len(writer) - 8) % 8 == 0:
                break
        self._deletion = Template(writer)

    def encode(
        self,
        time_ns: int,
        positions: NDArray,
        orientations: NDArray,
        points: NDArray,
        forces: NDArray,
    ) -> bytes:
        """Body poses (N, 3), (N, 4); contact points and the forces there (M, 3), world axes."""
        q = orientations[self._rows]
        self._poses[:, :3] = positions[self._rows] + rotate(q, self._positions)
        self._poses[:, 3:] = multiply(q, self._orientations)
        bodies = self._bodies.encode(time_ns, {"poses": self._poses})
        carried = np.any(forces != 0.0, axis=1)
        arrows = self._encode_arrows(time_ns, points[carried], forces[carried])
        deletion = self._deletion.encode(time_ns)[8:] if self._anew else b""
        deleting = len(_NAMESPACES) if self._anew else 0
        self._anew = False
        return b"".join(
            (
                bodies[:4],
                struct.pack("<I", deleting + self._body_count + len(arrows)),
                deletion,
                arrows.tobytes(),
                bodies[8:],
            )
        )

    def _encode_arrows(self, time_ns: int, points: NDArray, forces: NDArray) -> NDArray:
        count = len(points)
        total = max(count, self._arrows_before)
        block = np.empty((total, len(self._arrow)), np.uint8)
        block[:] = self._arrow

        def column(offset: int, dtype: str, number: int) -> NDArray:
            size = np.dtype(dtype).itemsize * number
            return block[:, offset : offset + size].view(dtype) if total else np.empty((0, number))

        sec, nanosec = split_stamp(time_ns)
        for offset in self._stamps_at:
            column(offset, "<u4", 2)[:] = (sec & 0xFFFFFFFF, nanosec)
        column(self._id_at, "<i4", 1)[:, 0] = np.arange(total)
        column(self._action_at, "<i4", 1)[count:] = _DELETE
        ends = column(self._points_at, "<f8", 6)
        ends[:count, :3] = points
        ends[:count, 3:] = points + self._arrows.vectors(forces)
        self._arrows_before = count
        return block


def _primitives(part: Part, width: float) -> list[tuple[int, tuple[float, ...], tuple]]:
    """(marker type, scale, offset along the part's axes) of what draws a part."""
    if part.kind == "sphere":
        return [(SPHERE, (2 * part.size[0],) * 3, (0, 0, 0))]
    if part.kind == "box":
        return [(CUBE, tuple(2 * h for h in part.size), (0, 0, 0))]
    if part.kind == "plane":
        return [(CUBE, (width, width, 1e-3 * width), (0, 0, -5e-4 * width))]
    if part.kind == "mesh":
        return [(TRIANGLE_LIST, (1.0, 1.0, 1.0), (0, 0, 0))]
    radius, half_length = part.size
    tube = (CYLINDER, (2 * radius, 2 * radius, 2 * half_length), (0, 0, 0))
    if part.kind == "cylinder":
        return [tube]
    ball = (2 * radius,) * 3
    return [tube, (SPHERE, ball, (0, 0, half_length)), (SPHERE, ball, (0, 0, -half_length))]
