"""Scene files: YAML in, a checked :class:`Scene` out, and from it as many worlds as you like.

The format is that of ``scene_schema.json`` beside this file: SI units, right-handed, z up,
quaternions (x, y, z, w). Every error names file, line, body, field, value and what is allowed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from .errors import SceneError
from .resources import PACKAGE, scene_path

if TYPE_CHECKING:
    from .located_yaml import Document
    from .world import World

Result = TypeVar("Result")

_BUILDERS = {
    "particle": "Particle",
    "sphere": "Sphere",
    "box": "Box",
    "capsule": "Capsule",
    "cylinder": "Cylinder",
    "half_space": "HalfSpace",
    "convex_hull": "ConvexHull",
    "triangle_mesh": "TriangleMesh",
    "height_field": "HeightField",
}


@cache
def scene_schema() -> dict[str, Any]:
    """The JSON schema (2020-12) of scene files."""
    schema: dict[str, Any] = json.loads((PACKAGE / "scene_schema.json").read_text("utf-8"))
    return schema


def load_scene(scene: str | os.PathLike[str]) -> Scene:
    """Reads a scene file.

    Args:
        scene: path of a scene file, or the name of a packaged scene such as ``"demo"``.

    Raises:
        SceneError: there is no such file, or what it says cannot be simulated.
    """
    path = scene_path(scene)
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"the scene file {path} cannot be read as UTF-8 text: {error}") from None
    return Scene.from_yaml(text, name=path.stem, source=str(path), folder=path.parent)


@dataclass(frozen=True)
class Scene:
    """A checked scene.

    Attributes:
        name: short name, the stem of the file.
        text: the YAML as written.
        data: the same as dicts, lists and numbers, mesh files replaced by their vertices.
            Not to be changed.
    """

    name: str
    text: str
    data: dict[str, Any] = field(repr=False)
    _document: Document = field(repr=False, compare=False)

    @classmethod
    def from_yaml(
        cls,
        text: str,
        *,
        name: str = "scene",
        source: str = "scene",
        folder: Path | None = None,
    ) -> Scene:
        """Reads a scene from YAML text.

        Args:
            name: name of the scene.
            source: what error messages call the text, usually its path.
            folder: where relative paths of mesh files start; None allows no mesh files.

        Raises:
            SceneError: what the text says cannot be simulated.
        """
        from . import located_yaml

        if not isinstance(text, str):
            raise SceneError.about(None, "text", text, "the YAML text of a scene")
        try:
            document = located_yaml.parse(text, source, scene_schema(), _subject)
        except ValueError as error:
            raise SceneError(str(error)) from None
        _check_names(document)
        scene = cls(name, text, _with_meshes(document, folder), document)
        scene.build()  # the world has the last word on what can be simulated
        return scene

    @property
    def bodies(self) -> list[dict[str, Any]]:
        """The bodies as in the file, in the order of their rows."""
        bodies: list[dict[str, Any]] = self.data["bodies"]
        return bodies

    def build(self, **settings: Any) -> World:
        """A new world in the initial state.

        Args:
            settings: fields of :class:`rb_physics.Settings` that replace those of the file.

        Raises:
            SceneError: a setting is not allowed.
        """
        from .settings import Settings
        from .world import World

        chosen: dict[str, Any] = dict(self.data.get("settings", {}))
        chosen |= {key: self.data[key] for key in ("gravity", "dt") if key in self.data}
        chosen |= settings
        document = self._document
        if settings:
            Settings.from_keywords(None, settings)  # a mistake in these is not one in the file
        world = _located(document, ("settings",), None, partial(World, **chosen))
        for row, body in enumerate(self.bodies):
            at, name = ("bodies", row), body["name"]
            shape = _located(document, (*at, "shape"), name, partial(_shape, body["shape"]))
            _located(document, at, name, partial(world.add_body, shape, **_given(body)))
        return world

    def to_yaml(self) -> str:
        """YAML that :meth:`from_yaml` reads back to the same scene, needing no other file."""
        if self.data is self._document.data:
            return self.text
        import yaml

        text: str = yaml.safe_dump(self.data, sort_keys=False, default_flow_style=None)
        return text


def _subject(data: Any, path: tuple[str | int, ...]) -> tuple[str, tuple[str | int, ...]]:
    """Splits ``bodies[3].mass`` into ``body 'crate'`` and ``mass`` for messages."""
    if len(path) < 3 or path[0] != "bodies" or path[2] == "name":
        return "", path
    body = data["bodies"][path[1]]
    name = body.get("name") if isinstance(body, dict) else None
    return (f"body {name!r}", path[2:]) if isinstance(name, str) else ("", path)


def _check_names(document: Document) -> None:
    first: dict[str, int] = {}
    for row, body in enumerate(document.data["bodies"]):
        name, line = body["name"], document.line(("bodies", row, "name"))
        if name in first:
            raise SceneError(
                f"{document.name}:{line}: body name {name!r} is already taken by the body in line "
                f"{first[name]}; names must be unique",
                body=name,
                field="name",
            )
        first[name] = line


def _located(
    document: Document, path: tuple[str | int, ...], body: str | None, act: Callable[[], Result]
) -> Result:
    """Runs `act`; its errors get file, line and body in front."""
    try:
        return act()
    except (ValueError, TypeError) as error:
        name = getattr(error, "field", None)
        inner = tuple(name.split(".")) if name else ()
        inner = inner[1:] if inner[:1] == path[-1:] else inner
        sentence = str(error)
        if body is not None and repr(body) not in sentence:
            sentence = f"body {body!r}: {sentence}"
        line = document.line((*path, *inner))
        raise SceneError(f"{document.name}:{line}: {sentence}", body=body, field=name) from error


def add_body(world: World, body: dict[str, Any]) -> Any:
    """Adds one body, described as in a scene file, and returns it. Raises SceneError."""
    return world.add_body(_shape(body["shape"]), **_given(body))


_CHANGEABLE = (
    "position", "orientation", "linear_velocity", "angular_velocity", "friction",
    "static_friction", "rolling_friction", "spinning_friction", "restitution",
)  # fmt: skip


def parse_body(text: str, source: str = "body", name: str | None = None) -> dict[str, Any]:
    """One body as in a scene file (YAML), checked against the schema; meshes by their vertices.

    `name`, when given, is its name in place of that in the text. Raises SceneError, as scene files
    do.
    """
    rule = scene_schema()["$defs"]["body"]
    if name is None:
        return _parse_part(text, source, rule)
    from . import checks

    body = _parse_part(text, source, {**rule, "required": ["shape"]})
    return {**body, "name": checks.name(name, "body")}


def parse_change(text: str, source: str = "change") -> dict[str, Any]:
    """What is to become of a body: YAML with its `name` and any of the fields of a scene file that
    can change while it is simulated. Raises SceneError.
    """
    body = scene_schema()["$defs"]["body"]["properties"]
    properties = {key: body[key] for key in ("name", *_CHANGEABLE)}
    return _parse_part(
        text, source, {"type": "object", "properties": properties, "required": ["name"],
                       "additionalProperties": False}
    )  # fmt: skip


def _parse_part(text: str, source: str, rule: dict[str, Any]) -> dict[str, Any]:
    from . import located_yaml

    schema = {"$defs": scene_schema()["$defs"], **rule}
    try:
        data: dict[str, Any] = located_yaml.parse(text, source, schema).data
    except ValueError as error:  # a text is no file
        raise SceneError(str(error).replace(": the file is empty", ": the text is empty")) from None
    if "file" in str(data.get("shape")):
        _no_files(data["shape"], data.get("name", source))
    return data


def _no_files(shape: dict[str, Any], body: str) -> None:
    if "file" in shape:
        raise SceneError(
            f"body {body!r}: shape.file is {shape['file']!r}; a body that is added while the "
            "simulation runs gives its vertices instead",
            body=body,
            field="shape",
        )
    for part in shape.get("parts", ()):
        _no_files(part["shape"], body)


def _given(body: dict[str, Any]) -> dict[str, Any]:
    """The arguments of World.add_body in a body's description."""
    given = {key: value for key, value in body.items() if key != "shape"}
    if "frames" in given:
        given["frames"] = {name: _pose(frame) for name, frame in given["frames"].items()}
    return given


def _pose(frame: dict[str, Any]) -> tuple[list[float], list[float]]:
    return frame.get("position", [0, 0, 0]), frame.get("orientation", [0, 0, 0, 1])


def _shape(data: dict[str, Any]) -> Any:
    import rb_physics

    given = {key: value for key, value in data.items() if key != "type"}
    if data["type"] == "compound":
        parts = [(_shape(part["shape"]), *_pose(part)) for part in given["parts"]]
        return rb_physics.Compound(parts)
    build = getattr(rb_physics, _BUILDERS[data["type"]], None)
    if build is None:
        raise SceneError(
            f"this version cannot simulate the shape {data['type']}", field="shape.type"
        )
    return build(**given)


def _with_meshes(document: Document, folder: Path | None) -> dict[str, Any]:
    """The data with every mesh file replaced by what it holds; the same object if there is none."""
    from .mesh_file import inline_mesh

    def shape(data: dict[str, Any], path: tuple[str | int, ...]) -> dict[str, Any]:
        if data["type"] == "compound":
            parts = []
            for i, part in enumerate(data["parts"]):
                inner = shape(part["shape"], (*path, "parts", i, "shape"))
                parts.append(part if inner is part["shape"] else {**part, "shape": inner})
            same = all(a is b for a, b in zip(parts, data["parts"], strict=True))
            return data if same else {**data, "parts": parts}
        if data["type"] not in ("convex_hull", "triangle_mesh"):
            return data
        name = document.data["bodies"][path[1]]["name"]
        return _located(document, path, name, lambda: inline_mesh(data, folder))

    bodies = []
    for row, body in enumerate(document.data["bodies"]):
        inner = shape(body["shape"], ("bodies", row, "shape"))
        bodies.append(body if inner is body["shape"] else {**body, "shape": inner})
    data: dict[str, Any] = document.data
    if all(a is b for a, b in zip(bodies, data["bodies"], strict=True)):
        return data
    return {**data, "bodies": bodies}
