"""What the bodies look like: drawable parts in body coordinates, as markers, URDF and views need.

The description of all bodies is stored with each recording (`bodies.json`), so that a view can be
made from the log alone.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .quaternions import from_z_axis, multiply, rotate

FORMAT_VERSION = 1
_IDENTITY = (0.0, 0.0, 0.0, 1.0)
_PARTICLE_RADIUS = 0.02  # m, of the dot that stands for a body without extent


@dataclass(frozen=True)
class Part:
    """One primitive of a body.

    `size` in m: sphere (radius), box (half extents), capsule and cylinder (radius, half_length;
    axis z), plane () with the solid below its local z = 0, mesh () with `vertices` and `triangles`.
    """

    kind: str
    size: tuple[float, ...] = ()
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    orientation: tuple[float, ...] = _IDENTITY
    vertices: tuple[tuple[float, ...], ...] = ()
    triangles: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class BodyDescription:
    """A body as outputs and views need it. Frames: name -> (position, orientation)."""

    name: str
    type: str  # dynamic, static, kinematic
    mass: float  # kg; 0 unless dynamic
    center_of_mass: tuple[float, ...]  # m, body coordinates
    parts: tuple[Part, ...]
    frames: Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]] = field(default_factory=dict)
    friction: float | None = None  # coefficient while sticking; None in recordings of format 1
    # About the centre of mass in the axes of the body, kg m², row by row; None unless dynamic.
    inertia: tuple[float, ...] | None = None

    @property
    def radius(self) -> float:
        """Of a ball about the body's origin that holds all parts, m; 0 for planes alone."""
        return max((_part_radius(part) for part in self.parts), default=0.0)


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in np.asarray(values, np.float64).reshape(-1))


def shape_parts(shape: Any) -> tuple[Part, ...]:
    """The parts of a shape of the Python face. Raises TypeError for an unknown class."""
    kind = type(shape).__name__
    if kind == "Particle":
        return (Part("sphere", (_PARTICLE_RADIUS,)),)
    if kind == "Sphere":
        return (Part("sphere", (float(shape.radius),)),)
    if kind == "Box":
        return (Part("box", _floats(shape.half_extents)),)
    if kind in ("Capsule", "Cylinder"):
        return (Part(kind.lower(), (float(shape.radius), float(shape.half_length))),)
    if kind == "HalfSpace":
        normal = np.asarray(shape.normal, np.float64)
        position = normal * float(shape.offset)
        return (Part("plane", (), _floats(position), _floats(from_z_axis(normal))),)
    if kind == "HeightField":
        return (_mesh(*height_field_mesh(shape.heights, shape.spacing)),)
    if kind == "TriangleMesh":
        return (_mesh(shape.vertices, shape.triangles),)
    if kind == "ConvexHull":
        fans = [(f[0], f[i], f[i + 1]) for f in shape.faces for i in range(1, len(f) - 1)]
        return (_mesh(shape.points, fans),)
    if kind == "Compound":
        return tuple(
            _moved(part, position, orientation)
            for child, position, orientation in shape.parts
            for part in shape_parts(child)
        )
    raise TypeError(f"shape {kind} has no picture")


def _mesh(vertices: Any, triangles: Any) -> Part:
    return Part(
        "mesh",
        vertices=tuple(_floats(v) for v in np.asarray(vertices)),
        triangles=tuple(tuple(int(i) for i in t) for t in np.asarray(triangles)),
    )


def height_field_mesh(heights: Any, spacing: Any) -> tuple[NDArray, NDArray]:
    """Vertices (N, 3) and triangles (M, 3): heights[i, j] is at x = i spacing, y = j spacing."""
    heights = np.asarray(heights, np.float64)
    dx, dy = np.broadcast_to(np.asarray(spacing, np.float64), (2,))
    rows, columns = heights.shape
    x, y = np.meshgrid(np.arange(rows) * dx, np.arange(columns) * dy, indexing="ij")
    vertices = np.stack([x, y, heights], axis=-1).reshape(-1, 3)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    right, up = corner + columns, corner + 1
    lower = np.stack([corner, right, up], axis=-1)
    upper = np.stack([right, right + 1, up], axis=-1)
    return vertices, np.concatenate([lower, upper])


def _moved(part: Part, position: Any, orientation: Any) -> Part:
    q = np.asarray(orientation, np.float64)[None]
    moved = np.asarray(position) + rotate(q, np.array([part.position]))[0]
    turned = multiply(q, np.array([part.orientation]))[0]
    return Part(
        part.kind, part.size, _floats(moved), _floats(turned), part.vertices, part.triangles
    )


def _part_radius(part: Part) -> float:
    if part.kind == "plane":
        return 0.0
    center = float(np.linalg.norm(part.position))
    if part.kind == "mesh":
        return center + float(np.max(np.linalg.norm(part.vertices, axis=1), initial=0.0))
    if part.kind == "capsule":
        return center + sum(part.size)
    return center + float(np.linalg.norm(part.size))


def describe(bodies: Iterable[Any]) -> list[BodyDescription]:
    """The bodies of a world, in row order."""
    described = []
    for body in bodies:
        dynamic = body.type == "dynamic"
        frames = {
            name: (_floats(position), _floats(orientation))
            for name, (position, orientation) in dict(getattr(body, "frames", {}) or {}).items()
        }
        center = _floats(body.center_of_mass) if dynamic else (0.0, 0.0, 0.0)
        described.append(
            BodyDescription(
                body.name,
                body.type,
                float(body.mass) if dynamic else 0.0,
                center,
                shape_parts(body.shape),
                frames,
                float(body.static_friction),
                _floats(body.inertia) if dynamic else None,
            )
        )
    return described


def to_json(bodies: list[BodyDescription]) -> str:
    """The text of bodies.json."""
    content = {"format_version": FORMAT_VERSION, "bodies": [asdict(body) for body in bodies]}
    return json.dumps(content, separators=(",", ":"))


def from_json(text: str) -> list[BodyDescription]:
    """Raises ValueError for text that isn't such a description."""
    try:
        content = json.loads(text)
        if content["format_version"] > FORMAT_VERSION:
            raise ValueError(
                f"bodies.json has format version {content['format_version']}; this version of "
                f"rb_physics reads up to {FORMAT_VERSION}: install a newer one"
            )
        return [_body(body) for body in content["bodies"]]
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"bodies.json is damaged: {error!r}") from None


def _body(raw: dict[str, Any]) -> BodyDescription:
    parts = tuple(
        Part(
            str(part["kind"]),
            _floats(part["size"]),
            _floats(part["position"]),
            _floats(part["orientation"]),
            tuple(_floats(v) for v in part["vertices"]),
            tuple(tuple(int(i) for i in t) for t in part["triangles"]),
        )
        for part in raw["parts"]
    )
    frames = {str(k): (_floats(p), _floats(q)) for k, (p, q) in raw["frames"].items()}
    center = _floats(raw["center_of_mass"])
    friction, inertia = raw.get("friction"), raw.get("inertia")
    return BodyDescription(str(raw["name"]), str(raw["type"]), float(raw["mass"]), center, parts,
                           frames, None if friction is None else float(friction),
                           None if inertia is None else _floats(inertia))  # fmt: skip
