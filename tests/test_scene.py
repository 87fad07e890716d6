"""Scene files: what they build, and what a mistake in one is answered with."""

from __future__ import annotations

import dataclasses
import inspect
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import rb_physics as rb
from rb_physics import scene as scene_module
from rb_physics.resources import packaged_scenes, scene_path
from rb_physics.scene import Scene, scene_schema

GOOD = """\
gravity: [0, 0, -1.62]
dt: 0.002
settings: {impact_law: sequential, restitution_combine: mean}
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - name: crate
    shape: {type: box, half_extents: [0.1, 0.2, 0.3]}
    density: 500
    position: [1, 2, 3]
    orientation: [0, 0, 1, 0]
    linear_velocity: [1, 0, 0]
    angular_velocity: [0, 1, 0]
    friction: 0.3
    static_friction: 0.4
    rolling_friction: 1e-3
    spinning_friction: 2e-3
    restitution: 0.1
    frames: {thruster: {position: [0.1, 0, 0]}, eye: {orientation: [1, 0, 0, 0]}}
  - {name: hand, type: kinematic, shape: {type: sphere, radius: 0.1}, position: [0, 0, 5]}
  - name: plate
    shape: {type: box, half_extents: [1, 1, 0.01]}
    mass: 2
    inertia: [[1, 0, 0], [0, 2, 0], [0, 0, 3]]   # a lamina: 1 + 2 = 3 is legal
    center_of_mass: [0.1, 0, 0]
    position: [5, 5, 5]
"""


def test_scene_builds_what_it_says() -> None:
    world = Scene.from_yaml(GOOD).build()
    assert world.dt == 0.002
    assert world.gravity.tolist() == [0, 0, -1.62]
    assert world.settings.impact_law == "sequential"
    assert world.settings.restitution_combine == "mean"
    assert [body.name for body in world.bodies] == ["ground", "crate", "hand", "plate"]
    assert [body.type for body in world.bodies] == ["static", "dynamic", "kinematic", "dynamic"]
    crate = world["crate"]
    # 500 kg/m^3 times 0.2 * 0.4 * 0.6 m^3; a few roundings of 1e-16 each
    assert crate.mass == pytest.approx(24.0, rel=1e-14)
    assert crate.position.tolist() == [1, 2, 3]
    assert crate.orientation.tolist() == [0, 0, 1, 0]
    assert crate.linear_velocity.tolist() == pytest.approx([1, 0, 0], abs=1e-15)
    # stored as angular momentum: back through the inertia, a few roundings
    assert crate.angular_velocity.tolist() == pytest.approx([0, 1, 0], abs=1e-14)
    position, orientation = crate.frames["thruster"]
    assert np.array_equal(position, [0.1, 0, 0])
    assert np.array_equal(orientation, [0, 0, 0, 1])
    assert np.array_equal(crate.frames["eye"][1], [1, 0, 0, 0])
    plate = world["plate"]
    assert np.allclose(plate.inertia, np.diag([1, 2, 3]), rtol=1e-14, atol=0)
    assert plate.center_of_mass.tolist() == [0.1, 0, 0]


def test_each_build_is_a_world_of_its_own_and_equal() -> None:
    scene = Scene.from_yaml(GOOD)
    one, two = scene.build(), scene.build()
    assert one.state_hash == two.state_hash
    one.step(3)
    assert one.state_hash != two.state_hash
    two.step(3)
    assert one.state_hash == two.state_hash


def test_build_takes_other_settings() -> None:
    scene = Scene.from_yaml(GOOD)
    assert scene.build(dt=0.01, stepper="event").settings.stepper == "event"
    with pytest.raises(rb.SceneError, match="stepper is 'fixd'"):
        scene.build(stepper="fixd")


def test_text_round_trip() -> None:
    scene = Scene.from_yaml(GOOD)
    assert scene.text == GOOD
    assert scene.to_yaml() == GOOD
    assert Scene.from_yaml(scene.to_yaml()).build().state_hash == scene.build().state_hash


def test_load_scene_takes_a_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(GOOD)
    scene = rb.load_scene(path)
    assert scene.name == "mine"
    assert len(scene.bodies) == 4
    assert rb.load_scene(str(path)).build().state_hash == scene.build().state_hash


@pytest.mark.parametrize("name", packaged_scenes())
def test_packaged_scene_builds_and_starts(name: str) -> None:
    scene = rb.load_scene(name)
    assert scene.data["description"]
    world = scene.build()
    world.step(5)
    assert np.isfinite(world.positions).all()
    # touching at most: boxes in the files touch exactly, and 0.1 * 3 is not 0.3 in binary
    assert world.stats.max_penetration < 1e-9


def test_demo_scene_holds_what_the_demo_needs() -> None:
    world = rb.load_scene("demo").build()
    names = [body.name for body in world.bodies]
    assert {"ground", "ball", "bouncer", "spinner", "box_0", "box_1"} <= set(names)
    moments = np.linalg.eigvalsh(world["spinner"].inertia)
    assert len(set(np.round(moments, 9))) == 3


def test_schema_is_valid_and_published() -> None:
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    file = Path(inspect.getfile(Scene)).with_name("scene_schema.json")
    assert json.loads(file.read_text("utf-8")) == scene_schema()


def test_schema_knows_what_python_knows() -> None:
    schema = scene_schema()
    # `unknown` only answers keywords that there aren't.
    body = set(inspect.signature(rb.World.add_body).parameters) - {"self", "unknown"}
    assert set(schema["$defs"]["body"]["properties"]) == body
    settings = {field.name for field in dataclasses.fields(rb.Settings)} - {"gravity", "dt"}
    assert set(schema["properties"]["settings"]["properties"]) == settings


SHAPES = {
    "particle": "{type: particle}",
    "sphere": "{type: sphere, radius: 0.5}",
    "box": "{type: box, half_extents: [0.1, 0.2, 0.3]}",
    "capsule": "{type: capsule, radius: 0.1, half_length: 0.2}",
    "cylinder": "{type: cylinder, radius: 0.1, half_length: 0.2}",
    "half_space": "{type: half_space, normal: [0, 0, 1], offset: 0}",
    "convex_hull": "{type: convex_hull, points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}",
    "triangle_mesh": "{type: triangle_mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}",
    "height_field": "{type: height_field, heights: [[0, 0.1], [0.2, 0]], spacing: 0.5}",
    "compound": "{type: compound, parts: [{shape: {type: sphere, radius: 0.1}}, {shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, position: [1, 0, 0]}]}",
}


@pytest.mark.parametrize("kind", SHAPES)
def test_every_shape_can_be_written(kind: str) -> None:
    if not hasattr(rb, scene_module._BUILDERS.get(kind, "Compound")):
        pytest.skip(f"this version has no {kind}")
    static = kind in ("half_space", "triangle_mesh", "height_field")
    rest = "type: static" if static else "mass: 1"
    scene = Scene.from_yaml(f"bodies: [{{name: thing, shape: {SHAPES[kind]}, {rest}}}]")
    shape = scene.build()["thing"].shape
    assert type(shape).__name__.lower() == kind.replace("_", "")
    assert set(scene_schema()["$defs"]["shape"]["properties"]["type"]["enum"]) == set(SHAPES)


CRATE = """\
bodies:
  - name: crate
    shape: {type: box, half_extents: [0.1, 0.1, 0.1]}
"""
BALL = "bodies:\n  - {name: ball, mass: 1, shape: "


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (CRATE + "    mass: -1", "4: body 'crate': mass is -1; it must be greater than 0 (kg"),
        (CRATE + "    mass: 0", "4: body 'crate': mass is 0; it must be greater than 0"),
        (CRATE + "    mass: .nan", "4: body 'crate': mass is .nan; it must be a finite number"),
        (CRATE + "    density: .inf", "4: body 'crate': density is .inf; it must be a finite"),
        (CRATE, "body 'crate': neither of mass and density given"),
        (CRATE + "    mass: 1\n    density: 1", "body 'crate': both of mass and density given"),
        (CRATE + "    mas: 1", "4: body 'crate': unknown key mas (did you mean mass?)"),
        (CRATE + "    mass: 1\n    restitution: 1.5", "5: body 'crate': restitution is 1.5"),
        (CRATE + "    mass: 1\n    friction: -0.1", "5: body 'crate': friction is -0.1"),
        (CRATE + "    mass: 1\n    type: statik", "'statik' (did you mean static?)"),
        (
            CRATE + "    mass: 1\n    friction: 0.5\n    static_friction: 0.4",
            "6: body 'crate': static_friction is 0.4; it must be",
        ),
        (
            CRATE + "    mass: 1\n    orientation: [0, 0, 0, 0]",
            "5: body 'crate': orientation is [0, 0, 0, 0]; it must be a unit quaternion",
        ),
        (
            CRATE + "    mass: 1\n    orientation: [0, 0, 0.1, 1]",
            "5: body 'crate': orientation is [0, 0, 0.1, 1]; it must be a unit quaternion",
        ),
        (CRATE + "    mass: 1\n    orientation: [0, 0, 1]", "5: body 'crate': orientation is"),
        (
            CRATE + "    mass: 1\n    inertia: [1, 1, 2.00001]",
            "5: body 'crate': inertia is [1, 1, 2.00001]; it must be that of a real body",
        ),
        (CRATE + "    mass: 1\n    inertia: [1, 1, -1]", "5: body 'crate': inertia is"),
        (CRATE + "    mass: 1\n    inertia: 1", "5: body 'crate': inertia is 1; it must be a list"),
        (
            CRATE + "    mass: 1\n    frames:\n      a: {orientation: [0, 0, 0, 2]}",
            "6: body 'crate': frames.a.orientation is [0, 0, 0, 2]; it must be a unit quaternion",
        ),
        (CRATE + "    mass: 1\n    frames: {a-b: {}}", "5: body 'crate': frames is 'a-b'; it must"),
        (CRATE + "    mass: 1\n    frames: {com: {}}", "5: body 'crate': frames is 'com'"),
        (
            CRATE + "    mass: 1\n    position: [0, 0, high]",
            "5: body 'crate': position[2] is 'high'; it must be a number",
        ),
        (
            CRATE + "    type: static\n    linear_velocity: [1, 0, 0]",
            "5: body 'crate' is static; linear_velocity must be zero",
        ),
        (
            BALL + "{type: sphere, radius: 0}}",
            "2: body 'ball': shape.radius is 0; it must be greater",
        ),
        (BALL + "{type: sphere}}", "2: body 'ball': shape.radius is missing (m)"),
        (BALL + "{type: spher, radius: 1}}", "shape.type is 'spher' (did you mean sphere?)"),
        (BALL + "{type: box, half_extents: [1, 1, 0]}}", "shape.half_extents[2] is 0"),
        (BALL + "{type: box, half_extents: [1, 1]}}", "shape.half_extents is [1, 1]"),
        (
            BALL + "{type: half_space, normal: [0, 0, 1], offset: 0}}",
            "2: body 'ball': type is 'dynamic'; it must be 'static' for a half_space",
        ),
        (
            BALL + "{type: convex_hull, points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}}",
            "2: body 'ball': ",
        ),
        (BALL + "{type: convex_hull}}", "2: body 'ball': convex_hull needs either points, or file"),
        (
            BALL + "{type: convex_hull, file: a.stl}}",
            "2: body 'ball': file is 'a.stl', but a scene given as text has no folder",
        ),
        (
            "bodies: [{name: a, type: static, shape: {type: sphere, radius: 1}},\n"
            " {name: a, type: static, shape: {type: sphere, radius: 1}}]",
            "2: body name 'a' is already taken by the body in line 1",
        ),
        ("bodies: [{name: 9lives, shape: {type: particle}}]", "1: bodies[0].name is '9lives'"),
        ("bodies: [{name: a/b, shape: {type: particle}}]", "it becomes part of topic and frame"),
        ("bodies: [{name: world, shape: {type: particle}}]", "bodies[0].name is 'world'"),
        ('bodies: [{name: "a\\n", shape: {type: particle}}]', r"bodies[0].name is 'a\n'"),
        ("bodies: [{shape: {type: particle}}]", "1: bodies[0].name is missing"),
        ("bodies: []\ndt: 0", "2: dt is 0; it must be greater than 0 (s"),
        ("bodies: []\ngravity: [0, 0]", "2: gravity is [0, 0]; it must be a list of at least 3"),
        (
            "bodies: []\nsettings: {steper: fixed}",
            "unknown key settings.steper (did you mean stepper?)",
        ),
        ("bodies: []\nsettings: {threads: 0}", "2: settings.threads is 0; it must be at least 1"),
        ("gravity: [0, 0, 0]", "1: bodies is missing"),
        ("bodies: {}", "1: bodies is a mapping; it must be a list"),
    ],
)
def test_mistake_is_answered_with_file_line_field_value_and_rule(text: str, message: str) -> None:
    with pytest.raises(rb.SceneError) as error:
        Scene.from_yaml(text, source="file.yaml")
    assert str(error.value).startswith("file.yaml:")
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_nearly_unit_quaternion_is_normalised() -> None:
    world = Scene.from_yaml(CRATE + "    mass: 1\n    orientation: [0, 0, 0.0005, 1]").build()
    # one rounding per component
    assert np.linalg.norm(world["crate"].orientation) == pytest.approx(1.0, abs=3e-16)


def test_error_carries_body_and_field_for_programs() -> None:
    with pytest.raises(rb.SceneError) as error:
        Scene.from_yaml(CRATE + "    mass: 1\n    inertia: [1, 1, 3]")
    assert error.value.body == "crate"
    assert error.value.field == "inertia"


def test_unknown_scene_name_lists_the_packaged_ones() -> None:
    with pytest.raises(
        rb.SceneError, match=r"no packaged scene 'demmo'; did you mean 'demo'\?"
    ) as e:
        rb.load_scene("demmo")
    assert "tower10" in str(e.value)


def test_missing_file_and_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(rb.SceneError, match=r"nowhere\.yaml does not exist; give an existing"):
        rb.load_scene(tmp_path / "nowhere.yaml")
    with pytest.raises(rb.SceneError, match=r"is not a file; give an existing"):
        rb.load_scene(tmp_path)
    with pytest.raises(rb.SceneError, match=r"demo\.yaml does not exist"):
        rb.load_scene("elsewhere/demo.yaml")


def test_binary_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "picture.yaml"
    path.write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")
    with pytest.raises(rb.SceneError, match="cannot be read as UTF-8 text"):
        rb.load_scene(path)


def test_scene_path_of_packaged_scene_exists() -> None:
    assert scene_path("demo").is_file()


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("radius", "radus"),
        ("shape", "shap"),
        ("bodies", "bodis"),
        ("name", "nmae"),
        ("type", "typ"),
    ],
)
def test_a_misspelt_required_key_is_named(right, wrong):
    text = "bodies: [{name: ball, mass: 1, shape: {type: sphere, radius: 1}}]".replace(right, wrong)
    with pytest.raises(rb.SceneError, match=f"unknown key {wrong} .did you mean {right}"):
        rb.Scene.from_yaml(text)
