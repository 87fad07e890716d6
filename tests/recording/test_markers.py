"""Markers and URDF against rclpy's deserialiser and an XML parser."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pytest

from rb_physics.recording.geometry import BodyDescription, Part, from_json, to_json
from rb_physics.recording.markers import MarkerEncoder
from rb_physics.recording.palette import ForceArrows
from rb_physics.recording.quaternions import from_z_axis, multiply, rotate, rotate_inverse
from rb_physics.recording.urdf import scene_urdf

serialization = pytest.importorskip("rclpy.serialization")
from visualization_msgs.msg import Marker, MarkerArray  # noqa: E402

TIME = 12_000_000_345
TURN = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))  # 90 degrees about z


def body(name: str, *parts: Part, kind: str = "dynamic") -> BodyDescription:
    return BodyDescription(name, kind, 1.0 if kind == "dynamic" else 0.0, (0.0, 0.0, 0.0), parts)


TETRAHEDRON = Part(
    "mesh",
    vertices=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    triangles=((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)),
)
BODIES = [
    body("ground", Part("plane"), kind="static"),
    body("box", Part("box", (0.1, 0.2, 0.3), (1.0, 0.0, 0.0))),
    body("ball", Part("sphere", (0.5,))),
    body("pill", Part("capsule", (0.1, 0.4))),
    body("can", Part("cylinder", (0.1, 0.4)), kind="kinematic"),
    body("rock", TETRAHEDRON),
]
POSITIONS = np.arange(18.0).reshape(6, 3)
ORIENTATIONS = np.tile([0.0, 0.0, 0.0, 1.0], (6, 1))
ORIENTATIONS[1] = TURN


def encode(encoder: MarkerEncoder, forces: np.ndarray) -> list:
    points = np.arange(3.0 * len(forces)).reshape(-1, 3)
    data = encoder.encode(TIME, POSITIONS, ORIENTATIONS, points, forces)
    return serialization.deserialize_message(data, MarkerArray).markers


def test_bodies_are_drawn_where_they_are():
    markers = encode(MarkerEncoder("world", BODIES, ForceArrows(0.1, 1e3)), np.empty((0, 3)))
    assert {m.ns for m in markers} == {"bodies"}
    assert [m.id for m in markers] == list(range(8))
    kinds = [Marker.CUBE, Marker.CUBE, Marker.SPHERE, Marker.CYLINDER, Marker.SPHERE, Marker.SPHERE,
             Marker.CYLINDER, Marker.TRIANGLE_LIST]  # fmt: skip
    assert [m.type for m in markers] == kinds
    for m in markers:
        assert (m.header.frame_id, m.action) == ("world", Marker.ADD)
        assert m.header.stamp.sec * 10**9 + m.header.stamp.nanosec == TIME
        assert m.color.a == 1.0
    box = markers[1]
    p, q = box.pose.position, box.pose.orientation
    # The part sits 1 m along the body's x axis, which points along world y.
    assert np.allclose([p.x, p.y, p.z], [3.0, 5.0, 5.0], atol=1e-15)
    assert np.allclose([q.x, q.y, q.z, q.w], TURN, atol=1e-15)
    assert [box.scale.x, box.scale.y, box.scale.z] == [0.2, 0.4, 0.6]
    assert markers[4].pose.position.z == POSITIONS[3, 2] + 0.4
    triangles = np.array([[v.x, v.y, v.z] for v in markers[7].points])
    expected = np.array(TETRAHEDRON.vertices)[np.array(TETRAHEDRON.triangles).reshape(-1)]
    assert np.array_equal(triangles, expected)


def test_force_arrows_skip_zeros_and_stale_ones_are_deleted():
    encoder = MarkerEncoder("world", BODIES, ForceArrows(0.1, 1e3))
    forces = np.array([[0, 0, 10.0], [0, 0, 0], [5.0, 0, 0], [0, -2.0, 0]])
    arrows = [m for m in encode(encoder, forces) if m.ns == "contact_forces"]
    assert [(m.id, m.type, m.action) for m in arrows] == [
        (k, Marker.ARROW, Marker.ADD) for k in range(3)
    ]
    ends = [[[v.x, v.y, v.z] for v in m.points] for m in arrows]
    assert np.allclose(ends[0], [[0, 1, 2], [0, 1, 3]], atol=1e-15)
    assert np.allclose(ends[1], [[6, 7, 8], [6.5, 7, 8]], atol=1e-15)
    fewer = [m for m in encode(encoder, forces[:1]) if m.ns == "contact_forces"]
    assert [(m.id, m.action) for m in fewer] == [
        (0, Marker.ADD), (1, Marker.DELETE), (2, Marker.DELETE),
    ]  # fmt: skip
    none = [m for m in encode(encoder, forces[1:2]) if m.ns == "contact_forces"]
    assert [(m.id, m.action) for m in none] == [(0, Marker.DELETE)]
    assert all(m.ns == "bodies" for m in encode(encoder, forces[1:2]))


def test_when_the_bodies_are_others_what_was_drawn_goes_first():
    encoder = MarkerEncoder("world", BODIES, ForceArrows(0.1, 1e3), anew=True)
    first, second = encode(encoder, np.ones((2, 3))), encode(encoder, np.ones((1, 3)))
    assert [m.action for m in first] == [Marker.DELETEALL] * 2 + [Marker.ADD] * 10
    # Some viewers delete in the marker's own namespace only.
    assert {m.ns for m in first[:2]} == {m.ns for m in first[2:]}
    assert [m.id for m in first[2:4]] == [0, 1]
    assert [m.action for m in second] == [Marker.ADD, Marker.DELETE] + [Marker.ADD] * 8


def test_large_forces_are_drawn_by_their_logarithm():
    arrows = ForceArrows(0.1, 20.0)
    forces = np.array([[0, 0, 10.0], [0, 20.0, 0], [20.0 * np.e, 0, 0], [0, 0, 0]])
    expected = [[0, 0, 1.0], [0, 2.0, 0], [4.0, 0, 0], [0, 0, 0]]
    assert np.allclose(arrows.vectors(forces), expected, atol=1e-15)
    standing = ForceArrows.of(BODIES, 9.81)
    assert standing.knee == pytest.approx(9.81)


@pytest.mark.parametrize("anew", [False, True])
@pytest.mark.parametrize("frame", ["w", "world", "map_of_7"])
def test_any_frame_length_stays_aligned(frame, anew):
    encoder = MarkerEncoder(frame, BODIES[1:3], ForceArrows(1.0, 1e3), anew)
    data = encoder.encode(
        TIME, POSITIONS[1:3], ORIENTATIONS[1:3], np.ones((5, 3)), np.full((5, 3), 2.0)
    )
    markers = serialization.deserialize_message(data, MarkerArray).markers
    assert all(m.header.frame_id == frame for m in markers)
    assert all(m.header.stamp.sec * 10**9 + m.header.stamp.nanosec == TIME for m in markers)
    markers = [m for m in markers if m.action == Marker.ADD]
    assert len(markers) == 7
    assert all((m.points[1].x, m.points[1].z) == (3.0, 3.0) for m in markers[:5])


def test_urdf_has_a_floating_link_per_body():
    root = ElementTree.fromstring(scene_urdf(BODIES))
    links = [link.attrib["name"] for link in root.findall("link")]
    assert links == ["world", *(b.name for b in BODIES)]
    assert {joint.attrib["type"] for joint in root.findall("joint")} == {"floating"}
    box = root.findall("link")[2].find("visual")
    assert box.find("origin").attrib["xyz"] == "1 0 0"
    assert box.find("geometry/box").attrib["size"] == "0.2 0.4 0.6"
    assert len(root.findall("link")[4].findall("visual")) == 3  # a capsule is a tube and two balls


def test_urdf_has_what_moves_a_body_and_what_it_touches_with():
    inertia = (0.1, 0.01, 0.02, 0.01, 0.2, 0.03, 0.02, 0.03, 0.25)
    solid = BodyDescription(
        "b", "dynamic", 2.5, (0.1, 0.0, -0.3), BODIES[3].parts, {}, 0.5, inertia
    )
    half_hull = replace(solid, name="h", parts=(*BODIES[1].parts, TETRAHEDRON))
    point = replace(solid, name="p", inertia=(0.0,) * 9)
    links = ElementTree.fromstring(scene_urdf([*BODIES, solid, half_hull, point])).findall("link")
    of = {link.attrib["name"]: link for link in links}
    assert of["b"].find("inertial/origin").attrib["xyz"] == "0.1 0 -0.3"
    assert of["b"].find("inertial/mass").attrib["value"] == "2.5"
    assert of["b"].find("inertial/inertia").attrib == {
        "ixx": "0.1", "ixy": "0.01", "ixz": "0.02", "iyy": "0.2", "iyz": "0.03", "izz": "0.25",
    }  # fmt: skip
    counts = {name: len(link.findall("collision")) for name, link in of.items()}
    # Half-spaces, hulls and particles have none in URDF, and a part of a shape is no shape.
    assert counts == {
        "world": 0, "ground": 0, "box": 1, "ball": 1, "pill": 3, "can": 1, "rock": 0, "b": 3, "h": 0, "p": 0,
    }  # fmt: skip
    assert len(of["h"].findall("visual")) == 1
    assert all(of[name].find("inertial") is None for name in ("ground", "can"))


def test_urdf_turns_parts_as_they_are_turned():
    """Also where the middle angle is a right one, near which formulas with an arcsine lose half the digits."""
    transform = pytest.importorskip("scipy.spatial.transform")
    rng = np.random.default_rng(4)
    turns = [q / np.linalg.norm(q) for q in rng.normal(size=(50, 4))]
    for off in (0.0, 1e-9, -1e-12):
        for side in (1, -1):
            angles = [0.3, side * (np.pi / 2 + off), 0.7]
            turns.append(transform.Rotation.from_euler("xyz", angles).as_quat())
    part = BODIES[1].parts[0]
    bodies = [body(f"b{i}", replace(part, orientation=tuple(q))) for i, q in enumerate(turns)]
    links = ElementTree.fromstring(scene_urdf(bodies)).findall("link")[1:]
    for link, turn in zip(links, turns, strict=True):
        rpy = [float(word) for word in link.find("visual/origin").attrib["rpy"].split()]
        found = transform.Rotation.from_euler("xyz", rpy).as_matrix()
        # A handful of roundings of numbers of size 1.
        assert np.allclose(
            found, transform.Rotation.from_quat(turn).as_matrix(), atol=4e-15, rtol=0
        )


def test_bodies_survive_json():
    described = [*BODIES, replace(BODIES[1], inertia=tuple(np.linspace(0.1, 0.9, 9)))]
    assert from_json(to_json(described)) == described


@pytest.mark.parametrize(
    "text", ["", "{}", "[]", '{"format_version": 1, "bodies": [{}]}', '{"format_version": 99}']
)
def test_damaged_bodies_say_so(text):
    with pytest.raises(ValueError, match=r".+"):
        from_json(text)


def test_quaternions_agree_with_scipy():
    transform = pytest.importorskip("scipy.spatial.transform")
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 50, 4))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    v = rng.normal(size=(50, 3))
    rotation = transform.Rotation.from_quat(a)
    # A handful of roundings of numbers of size 1.
    assert np.allclose(rotate(a, v), rotation.apply(v), atol=2e-15)
    assert np.allclose(rotate_inverse(a, v), rotation.inv().apply(v), atol=2e-15)
    product = (rotation * transform.Rotation.from_quat(b)).as_matrix()
    assert np.allclose(
        transform.Rotation.from_quat(multiply(a, b)).as_matrix(), product, atol=2e-15
    )
    for direction in ([0, 0, 1.0], [0, 0, -1.0], [0.6, 0.0, -0.8]):
        q = from_z_axis(np.array(direction))
        assert np.allclose(rotate(q[None], np.array([[0, 0, 1.0]]))[0], direction, atol=1e-15)
