"""URDF into bodies: mass properties, shapes, places, and what is refused."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from rb_physics_nodes.urdf_body import UrdfError, body_from_urdf

import rb_physics as rb
from rb_physics.queries import bounding_box
from rb_physics.recording.geometry import describe
from rb_physics.recording.urdf import scene_urdf
from rb_physics.scene import add_body

INERTIA = '<inertia ixx="0.1" ixy="0.01" ixz="0.02" iyy="0.2" iyz="0.03" izz="0.25"/>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


def link(name: str, content: str = "") -> str:
    return f'<link name="{name}">{content}</link>'


def inertial(mass: float, origin: str = "") -> str:
    return f'<inertial>{origin}<mass value="{mass}"/>{INERTIA}</inertial>'


def joint(name: str, parent: str, child: str, kind: str = "fixed", origin: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{origin}{ends}</joint>'


def robot(*parts: str) -> str:
    return f'<?xml version="1.0"?><robot name="thing">{"".join(parts)}</robot>'


def test_links_that_are_welded_make_one_body_with_their_mass_properties() -> None:
    """Two equal point-like masses 0.6 m apart, the second turned by 90° about z."""
    turned = f'<origin xyz="0.6 0 0" rpy="0 0 {math.pi / 2!r}"/>'
    text = robot(
        link("a", inertial(3.0) + BALL), link("b", inertial(3.0) + BALL), joint("w", "a", "b", origin=turned)
    )  # fmt: skip
    body = body_from_urdf(text, "x")
    assert (body["name"], body["mass"]) == ("thing", 6.0)
    assert body["center_of_mass"] == pytest.approx([0.3, 0, 0], abs=1e-15)
    own = np.array([[0.1, 0.01, 0.02], [0.01, 0.2, 0.03], [0.02, 0.03, 0.25]])
    r = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    # Steiner: each mass is 0.3 m from the common centre, along x
    steiner = 2 * 3.0 * 0.09 * np.diag([0.0, 1, 1])
    assert np.array(body["inertia"]) == pytest.approx(own + r @ own @ r.T + steiner, abs=1e-15)
    world = rb.World()
    added = add_body(world, body)
    assert added.mass == 6.0
    parts = added.shape.parts
    assert [p[1] for p in parts][1] == pytest.approx((0.6, 0, 0), abs=1e-15)


def test_shapes_and_places() -> None:
    shapes = "".join(
        f'<collision><origin xyz="{x} 0 0" rpy="0.3 -0.4 0.5"/><geometry>{g}</geometry></collision>'
        for x, g in enumerate(
            ('<box size="0.2 0.4 0.6"/>', '<cylinder radius="0.1" length="0.5"/>',
             '<capsule radius="0.1" length="0.5"/>', '<sphere radius="0.3"/>')
        )
    )  # fmt: skip
    parts = body_from_urdf(robot(link("a", inertial(1.0) + shapes)), "x")["shape"]["parts"]
    assert [p["shape"] for p in parts] == [
        {"type": "box", "half_extents": [0.1, 0.2, 0.3]},
        {"type": "cylinder", "radius": 0.1, "half_length": 0.25},
        {"type": "capsule", "radius": 0.1, "half_length": 0.25},
        {"type": "sphere", "radius": 0.3},
    ]
    scipy = pytest.importorskip("scipy.spatial.transform")
    expected = scipy.Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_quat()
    for x, part in enumerate(parts):
        assert part["position"] == [x, 0, 0]
        assert part["orientation"] == pytest.approx(expected, abs=1e-15)


def test_a_body_that_hangs_on_the_world() -> None:
    origin = '<origin xyz="1 2 3"/>'
    for kind in ("fixed", "floating"):
        text = robot(
            link("world"), link("a", inertial(1.0) + BALL), joint("j", "world", "a", kind, origin)
        )
        body = body_from_urdf(text, "x")
        assert body["position"] == [1, 2, 3]
        assert body.get("type") == ("static" if kind == "fixed" else None)
        add_body(rb.World(), body)


def test_a_mesh_becomes_its_convex_hull(tmp_path) -> None:
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box(extents=(1, 1, 1)).export(tmp_path / "cube.stl")
    mesh = '<collision><geometry><mesh filename="cube.stl" scale="0.2 0.4 0.6"/></geometry></collision>'
    body = body_from_urdf(robot(link("a", inertial(1.0) + mesh)), "x", tmp_path)
    corners = np.array(body["shape"]["points"])
    assert corners.min(axis=0) == pytest.approx([-0.1, -0.2, -0.3], abs=1e-7)  # STL is float32
    assert corners.max(axis=0) == pytest.approx([0.1, 0.2, 0.3], abs=1e-7)
    with pytest.raises(UrdfError, match="does not exist") as caught:
        body_from_urdf(robot(link("a", inertial(1.0) + mesh.replace("cube", "no"))), "x", tmp_path)
    assert caught.value.code == "MISSING_ASSETS"
    with pytest.raises(UrdfError, match="can't name one"):
        body_from_urdf(robot(link("a", inertial(1.0) + mesh)), "x")


def test_a_body_of_robot_description_given_back_is_the_same() -> None:
    """As its links are in the scene's URDF, one beside the link `world` in a robot of its own."""
    world = rb.World()
    turned = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
    shapes = {
        "box": rb.Box(half_extents=(0.1, 0.2, 0.3)),
        "can": rb.Cylinder(radius=0.1, half_length=0.3),
        "axe": rb.Compound(
            [(rb.Box(half_extents=(0.1, 0.2, 0.3)), (0.5, 0, 0), turned), (rb.Sphere(radius=0.3), (0, 1, 0), (0, 0, 0, 1))]
        ),
        "pill": rb.Capsule(radius=0.1, half_length=0.3),
    }  # fmt: skip
    for name, shape in shapes.items():
        world.add_body(shape, name=name, mass=1.7)
    world.add_body(rb.ConvexHull(np.eye(4, 3)), name="hull", mass=1.7)
    scene = ElementTree.fromstring(scene_urdf(describe(world.bodies)))
    links = {link.get("name"): ElementTree.tostring(link).decode() for link in scene.iter("link")}
    back = rb.World()
    for name in shapes:
        given = body_from_urdf(f'<robot name="{name}">{links[name]}</robot>', "x")
        body, was = add_body(back, given), world[name]
        assert body.mass == was.mass
        # Three roundings: the parallel axis theorem of one link about its own centre.
        assert np.allclose(body.inertia, was.inertia, atol=1e-15, rtol=1e-15)
        assert np.allclose(body.center_of_mass, was.center_of_mass, atol=1e-16)
        lower, upper = bounding_box(body)
        assert np.allclose((lower, upper), bounding_box(was), atol=1e-14)
    assert type(back["box"].shape) is rb.Box and type(back["can"].shape) is rb.Cylinder
    with pytest.raises(UrdfError, match="no link has a collision"):
        body_from_urdf(f'<robot name="hull">{links["hull"]}</robot>', "x")


LAUGHS = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("<robot", "RESOURCE_PARSE_ERROR", "not valid XML"),
        (LAUGHS, "RESOURCE_PARSE_ERROR", "declares a document type"),
        ("<sdf/>", "UNSUPPORTED_FORMAT", "root <sdf>"),
        (robot(), "RESOURCE_PARSE_ERROR", "no link has no parent"),
        (robot("<link/>"), "RESOURCE_PARSE_ERROR", "a link has no name"),
        (robot(link("a"), link("b")), "RESOURCE_PARSE_ERROR", "a, b have no parent"),
        (robot(link("a", inertial(1.0))), "RESOURCE_PARSE_ERROR", "no link has a collision"),
        (robot(link("a", BALL)), "RESOURCE_PARSE_ERROR", "no link has an inertial mass"),
        (robot(link("a", inertial(0.0) + BALL)), "RESOURCE_PARSE_ERROR", "must be > 0"),
        (robot(link("a", inertial(math.nan) + BALL)), "RESOURCE_PARSE_ERROR", "1 finite number"),
        (robot(link("a"), joint("j", "a", "c")), "RESOURCE_PARSE_ERROR", "child of joint 'j'"),
        (
            robot(link("a", BALL), link("b"), joint("j", "a", "b", "continuous")),
            "UNSUPPORTED_FORMAT",
            "joint 'j' is continuous",
        ),
        (
            robot(link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")),
            "RESOURCE_PARSE_ERROR",
            "no link has no parent",
        ),
        (
            robot(link("world"), link("a", BALL), joint("j", "world", "a", "planar")),
            "UNSUPPORTED_FORMAT",
            "j (planar)",
        ),
        (
            robot(link("a", "<collision><geometry><plane/></geometry></collision>")),
            "UNSUPPORTED_ASSETS",
            "geometry <plane>",
        ),
        (
            robot(link("a", '<collision><geometry><box size="1 2"/></geometry></collision>')),
            "RESOURCE_PARSE_ERROR",
            "3 finite numbers",
        ),
        (
            robot(link("a", '<collision><geometry><mesh filename="package://p/a.stl"/></geometry></collision>')),
            "UNSUPPORTED_ASSETS",
            "only paths and file:",
        ),
    ],
)  # fmt: skip
def test_what_is_refused(text: str, code: str, words: str, tmp_path) -> None:
    with pytest.raises(UrdfError) as caught:
        body_from_urdf(text, "x", tmp_path)
    assert caught.value.code == code
    assert words in str(caught.value), str(caught.value)
