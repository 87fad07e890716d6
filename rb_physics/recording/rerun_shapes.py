"""Bodies as Rerun entities: one per body while they are few, one per kind of shape when many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription, Part
from .palette import RGBA, body_colors, typical_radius
from .quaternions import multiply, rotate

NAMED_BODIES = 50  # up to so many bodies each is an entity that can be selected by name
_TILES = 20  # along one side of a drawn half-space


class ShapeEntities:
    """Logs the shapes once, and their poses as columns."""

    def __init__(self, recording: Any, bodies: Sequence[BodyDescription], poses: NDArray) -> None:
        import rerun

        self._rr, self._rec = rerun, recording
        self._named: list[tuple[str, int]] = []  # (entity, row)
        # (entity, rows, local positions, local orientations) of many parts of one kind
        self._grouped: list[tuple[str, NDArray, NDArray, NDArray]] = []
        tile = _tile_size(bodies, poses)
        colors = body_colors(bodies)
        loose: list[tuple[int, Part]] = []
        for row, body in enumerate(bodies):
            entity = f"world/bodies/{body.name}"
            fixed = body.type == "static"
            parts = [part for part in body.parts if part.kind in ("plane", "mesh")]
            others = [part for part in body.parts if part.kind not in ("plane", "mesh")]
            if len(bodies) <= NAMED_BODIES or fixed or parts:
                self._named.append((entity, row))
                for i, part in enumerate([*parts, *others]):
                    name = entity if len(body.parts) == 1 else f"{entity}/part_{i}"
                    self._log_part(name, part, colors[row], tile)
            else:
                loose.extend((row, part) for part in others)
        self._group(loose, colors)

    def _log_part(self, entity: str, part: Part, color: RGBA, tile: float) -> None:
        """One static shape at its place in the body."""
        rr = self._rr
        place = {"centers": [part.position], "quaternions": [part.orientation]}
        style = {"colors": [color], "fill_mode": "solid"}
        shape: Any
        if part.kind == "sphere":
            shape = rr.Ellipsoids3D(radii=[part.size[0]], **place, **style)
        elif part.kind == "box":
            shape = rr.Boxes3D(half_sizes=[part.size], **place, **style)
        elif part.kind == "cylinder":
            radius, half = part.size
            shape = rr.Cylinders3D(radii=[radius], lengths=[2 * half], **place, **style)
        elif part.kind == "capsule":
            radius, half = part.size
            start = _capsule_start(np.array([part.position]), np.array([part.orientation]), half)
            shape = rr.Capsules3D(
                radii=[radius], lengths=[2 * half], translations=start,
                quaternions=[part.orientation], **style,
            )  # fmt: skip
        elif part.kind == "plane":
            vertices, triangles, colors = _checkered(part, tile)
            shape = rr.Mesh3D(
                vertex_positions=vertices, triangle_indices=triangles, vertex_colors=colors
            )
        else:
            vertices, triangles, normals = _flat_mesh(part)
            shape = rr.Mesh3D(
                vertex_positions=vertices, triangle_indices=triangles, vertex_normals=normals,
                albedo_factor=color,
            )  # fmt: skip
        self._rec.log(entity, shape, static=True)

    def _group(self, loose: list[tuple[int, Part]], colors: list[RGBA]) -> None:
        rr = self._rr
        for kind in ("sphere", "box", "cylinder", "capsule"):
            chosen = [(row, part) for row, part in loose if part.kind == kind]
            if not chosen:
                continue
            sizes = np.array([part.size for _, part in chosen])
            positions = np.array([part.position for _, part in chosen])
            orientations = np.array([part.orientation for _, part in chosen])
            rows = np.array([row for row, _ in chosen])
            style = {"colors": [colors[row] for row in rows], "fill_mode": "solid"}
            shape: Any
            if kind == "sphere":
                shape = rr.Ellipsoids3D(radii=sizes[:, 0], **style)
            elif kind == "box":
                shape = rr.Boxes3D(half_sizes=sizes, **style)
            elif kind == "cylinder":
                shape = rr.Cylinders3D(radii=sizes[:, 0], lengths=2 * sizes[:, 1], **style)
            else:
                positions = _capsule_start(positions, orientations, sizes[:, 1:])
                shape = rr.Capsules3D(radii=sizes[:, 0], lengths=2 * sizes[:, 1], **style)
            entity = f"world/bodies/{kind}{'es' if kind == 'box' else 's'}"
            self._rec.log(entity, shape, static=True)
            self._grouped.append((entity, rows, positions, orientations))

    def send(self, index: Any, poses: NDArray) -> None:
        """poses (T, N, 7) of all bodies at the times of a column."""
        rr, count = self._rr, len(poses)
        for entity, row in self._named:
            columns = rr.Transform3D.columns(
                translation=poses[:, row, :3], quaternion=poses[:, row, 3:]
            )
            self._rec.send_columns(entity, indexes=[index], columns=columns)
        for entity, rows, positions, orientations in self._grouped:
            q = poses[:, rows, 3:].reshape(-1, 4)
            places = rotate(q, np.tile(positions, (count, 1))) + poses[:, rows, :3].reshape(-1, 3)
            turned = multiply(q, np.tile(orientations, (count, 1)))
            columns = rr.InstancePoses3D.columns(translations=places, quaternions=turned)
            self._rec.send_columns(
                entity, indexes=[index], columns=columns.partition([len(rows)] * count)
            )


def _capsule_start(positions: NDArray, orientations: NDArray, half_lengths: Any) -> NDArray:
    """Rerun's capsules begin at their translation; ours lie about it."""
    down = np.zeros((len(positions), 3))
    down[:, 2:] = -np.asarray(half_lengths).reshape(-1, 1)
    start: NDArray = positions + rotate(orientations, down)
    return start


def _tile_size(bodies: Sequence[BodyDescription], poses: NDArray) -> float:
    """m: a round number such that the drawn half-space reaches well around the bodies."""
    moving = [row for row, body in enumerate(bodies) if body.type != "static"]
    spread = float(np.max(np.abs(poses[moving, :2]), initial=0.0))
    wanted = (1.6 * spread + 12 * typical_radius(bodies)) / (_TILES / 2)
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * next(step for step in (1, 2, 5, 10) if step * power >= wanted))


def _checkered(part: Part, tile: float) -> tuple[NDArray, NDArray, NDArray]:
    """A square of tiles in two greys on the plane: motion and scale can be seen against it."""
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
    i, j = np.meshgrid(np.arange(_TILES), np.arange(_TILES), indexing="ij")
    cells = np.stack([i.reshape(-1), j.reshape(-1)], axis=-1) - _TILES / 2
    flat = ((cells[:, None, :] + corner) * tile).reshape(-1, 2)
    local = np.column_stack([flat, np.zeros(len(flat))])
    q = np.array([part.orientation])
    vertices = np.asarray(part.position) + rotate(np.repeat(q, len(local), axis=0), local)
    base = 4 * np.arange(len(cells))[:, None]
    triangles = np.concatenate([base + np.array([0, 1, 2]), base + np.array([0, 2, 3])])
    dark = ((i + j) % 2).reshape(-1).astype(bool)
    shades = np.where(dark[:, None], (120, 125, 132), (142, 147, 154)).astype(np.uint8)
    return vertices, triangles, np.repeat(shades, 4, axis=0)


def _flat_mesh(part: Part) -> tuple[NDArray, NDArray, NDArray]:
    """Each triangle with vertices of its own, so that faces are shaded flat."""
    q = np.repeat(np.array([part.orientation]), len(part.vertices), axis=0)
    placed = np.asarray(part.position) + rotate(q, np.array(part.vertices))
    corners = placed[np.array(part.triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(lengths > 0, lengths, 1.0)
    vertices = corners.reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3), np.repeat(normals, 3, axis=0)
