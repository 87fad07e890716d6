"""STL and OBJ files in scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rb_physics as rb
from rb_physics.scene import Scene

trimesh = pytest.importorskip("trimesh")


def write_scene(folder: Path, shape: str, rest: str = "mass: 1") -> Path:
    path = folder / "scene.yaml"
    path.write_text(f"bodies:\n  - {{name: thing, {rest}, shape: {{{shape}}}}}\n")
    return path


@pytest.mark.parametrize("ending", ["stl", "obj"])
def test_hull_and_mesh_come_from_a_file_beside_the_scene(tmp_path: Path, ending: str) -> None:
    trimesh.creation.box((2.0, 4.0, 6.0)).export(tmp_path / f"block.{ending}")
    scene = rb.load_scene(
        write_scene(tmp_path, f"type: convex_hull, file: block.{ending}, scale: 0.1")
    )
    body = scene.build()["thing"]
    # a box of 0.2 x 0.4 x 0.6 m and 1 kg; STL stores single precision, hence 1e-6
    expected = np.diag([0.4**2 + 0.6**2, 0.2**2 + 0.6**2, 0.2**2 + 0.4**2]) / 12
    assert np.allclose(body.inertia, expected, rtol=1e-6, atol=1e-9)
    if not hasattr(rb, "TriangleMesh"):
        pytest.skip("this version has no TriangleMesh")
    mesh = rb.load_scene(
        write_scene(tmp_path, f"type: triangle_mesh, file: block.{ending}", "type: static")
    )
    assert mesh.build()["thing"].type == "static"


def test_written_scene_needs_no_mesh_file(tmp_path: Path) -> None:
    trimesh.creation.icosphere(subdivisions=1, radius=0.3).export(tmp_path / "ball.stl")
    shape = "type: compound, parts: [{shape: {type: convex_hull, file: ball.stl}}]"
    scene = rb.load_scene(write_scene(tmp_path, shape))
    (tmp_path / "ball.stl").unlink()
    again = Scene.from_yaml(scene.to_yaml())
    assert again.build().state_hash == scene.build().state_hash
    assert again.to_yaml() == scene.to_yaml()


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ("file: none.stl", "none.stl', which does not exist"),
        ("file: scene.yaml", "scene.yaml', it must end in .stl or .obj"),
        ("file: broken.stl", "broken.stl', which"),
        ("file: empty.obj", "empty.obj', which"),
        ("file: none.stl, points: [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]", "both file and points"),
        ("points: [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], scale: 2", "scale goes with file only"),
        ("file: none.stl, scale: 0", "shape.scale is 0; it must be greater than 0"),
    ],
)
def test_unusable_file_is_named(tmp_path: Path, shape: str, message: str) -> None:
    (tmp_path / "broken.stl").write_bytes(b"solid nothing\n facet")
    (tmp_path / "empty.obj").write_text("# nothing\n")
    with pytest.raises(rb.SceneError, match=r"scene\.yaml:2: body 'thing': ") as error:
        rb.load_scene(write_scene(tmp_path, f"type: convex_hull, {shape}"))
    assert message in str(error.value)
