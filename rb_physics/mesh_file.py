"""Meshes of scene files: given inline or as an STL or OBJ file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .errors import SceneError

_INLINE = {"convex_hull": ("points",), "triangle_mesh": ("vertices", "triangles")}


def inline_mesh(shape: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """A convex hull or triangle mesh of a scene file with its numbers inline.

    Args:
        shape: data of the shape, either with ``file`` (and ``scale``) or with numbers.
        folder: where a relative ``file`` starts; None allows no file.

    Raises:
        SceneError: both or neither given, no such file, or it holds no mesh.
    """
    kind = shape["type"]
    inline = _INLINE[kind]
    given = [key for key in inline if key in shape]
    if "file" not in shape:
        if len(given) < len(inline):
            raise SceneError(f"{kind} needs either {' and '.join(inline)}, or file", field="shape")
        if "scale" in shape:
            raise SceneError("scale goes with file only", field="shape.scale")
        return shape
    if given:
        raise SceneError(f"{kind} has both file and {given[0]}; give one", field="shape.file")
    if folder is None:
        raise SceneError(
            f"file is {shape['file']!r}, but a scene given as text has no folder to find it in; "
            "give the numbers inline",
            field="shape.file",
        )
    vertices, triangles = _read(folder / shape["file"], shape.get("scale", 1.0))
    if kind == "convex_hull":
        return {"type": kind, "points": vertices}
    return {"type": kind, "vertices": vertices, "triangles": triangles}


def _read(path: Path, scale: float) -> tuple[list[list[float]], list[list[int]]]:
    def error(problem: str) -> SceneError:
        return SceneError(f"file is {str(path)!r}, {problem}", field="shape.file")

    if path.suffix.lower() not in (".stl", ".obj"):
        raise error("it must end in .stl or .obj")
    if not path.is_file():
        raise error("which does not exist")
    try:
        import trimesh
    except ImportError:
        raise error(
            "but reading mesh files needs trimesh: pip install 'rb_physics[mesh]'"
        ) from None
    try:
        # force: an OBJ with several objects becomes one mesh; the default merges equal vertices
        mesh: Any = trimesh.load(path, force="mesh")
        vertices, triangles = mesh.vertices * scale, mesh.faces
    except Exception as problem:  # whatever a broken file makes the reader raise
        raise error(f"which cannot be read: {problem}") from None
    if len(triangles) == 0:
        raise error("which holds no triangles")
    return vertices.tolist(), triangles.tolist()
