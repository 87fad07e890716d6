"""S8: the reduced contact set names the features that met and lists each point once."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage, multiply, turn

Kind = rb.ContactKind
HALF = np.array([0.2, 0.3, 0.1])


def resting(shape, position, orientation, stage, on_box):
    """A body on a plane or on a large box whose top is z = 0; gravity holds it there."""
    world = stage.world(1e-3)
    if on_box:
        stage.fixed_box(world, (5, 5, 0.5), (0, 0, -0.5), friction=1.0)
    else:
        stage.plane(world, friction=1.0)
    body = stage.add(world, shape, 1.0, position, orientation, friction=1.0)
    return world, body


STAGES = [Stage(), Stage(attitude=tuple(turn((3, -1, 2), 2.0))), Stage(origin=(5.0, 7.0, -3.0))]


@pytest.mark.parametrize("stage", STAGES, ids=["flat", "tilted", "elsewhere"])
@pytest.mark.parametrize("on_box", [False, True])
@pytest.mark.parametrize("heading", [0.0, 0.4])
def test_face_on_face_has_the_four_corners(stage, on_box, heading):
    q = turn((0, 0, 1), heading)
    world, _body = resting(stage.box(HALF), (0, 0, HALF[2]), q, stage, on_box)
    world.step()
    contacts = world.contacts
    assert len(contacts) == 4
    assert {Kind(k) for k in contacts["kind"]} == {Kind.FACE_FACE}
    assert len(set(contacts["feature"])) == 4
    corners = np.array([(x, y) for x in (-0.2, 0.2) for y in (-0.3, 0.3)])
    c, s = np.cos(heading), np.sin(heading)
    expected = corners @ np.array([[c, s], [-s, c]])
    points = (contacts["point"] - stage.origin) @ stage.matrix
    gaps = np.linalg.norm(points[:, None, :2] - expected[None], axis=2)
    # A corner is a sum of three products; coordinates of a few metres round to 1e-15.
    assert gaps.min(axis=0).max() < 1e-13
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-13)
    np.testing.assert_allclose(
        contacts["normal"] @ stage.matrix, np.tile((0, 0, 1), (4, 1)), atol=1e-13
    )


@pytest.mark.parametrize("on_box", [False, True])
def test_edge_on_face_has_the_two_ends(on_box):
    stage = STAGES[1]
    # On its long lower edge, centre of mass straight above.
    tilt = np.arctan2(HALF[0], HALF[2])
    q = turn((0, 1, 0), tilt)
    world, body = resting(stage.box(HALF), (0, 0, np.hypot(HALF[0], HALF[2])), q, stage, on_box)
    contacts = rb.find_contacts(body, world.bodies[0], margin=1e-9)
    assert [Kind(k) for k in contacts["kind"]] == [Kind.EDGE_FACE] * 2
    points = (contacts["point"] - stage.origin) @ stage.matrix
    np.testing.assert_allclose(sorted(points[:, 1]), [-0.3, 0.3], atol=1e-13)


@pytest.mark.parametrize("on_box", [False, True])
def test_vertex_on_face(on_box):
    stage = STAGES[1]
    # The corner (-a, -b, -c) turned straight down.
    d = HALF / np.linalg.norm(HALF)
    axis = np.cross(-d, (0, 0, -1))
    q = turn(axis, np.arccos(d[2]))
    world, body = resting(stage.box(HALF), (0, 0, np.linalg.norm(HALF)), q, stage, on_box)
    contacts = rb.find_contacts(body, world.bodies[0], margin=1e-9)
    assert [Kind(k) for k in contacts["kind"]] == [Kind.VERTEX_FACE]
    np.testing.assert_allclose(contacts["point"][0], stage.point((0, 0, 0)), atol=1e-13)


def test_edge_on_edge_is_one_point():
    stage = STAGES[1]
    world = stage.world(1e-3)
    q = turn((0, 1, 0), np.pi / 4)
    low = stage.fixed_box(world, (0.1, 1, 0.1), (0, 0, 0), q)
    high = stage.add(
        world,
        stage.box((0.1, 1, 0.1)),
        1.0,
        (0.2, 0.1, 0.2 * np.sqrt(2)),
        multiply(turn((0, 0, 1), 1.0), q),
    )
    contacts = rb.find_contacts(high, low, margin=1e-9)
    assert [Kind(k) for k in contacts["kind"]] == [Kind.EDGE_EDGE]
    assert contacts["separation"][0] == pytest.approx(0, abs=1e-13)
    np.testing.assert_allclose(stage.matrix.T @ contacts["normal"][0], (0, 0, 1), atol=1e-12)


def test_offset_faces_keep_vertices_of_both():
    """Overhanging by half: two corners of each face lie inside the other."""
    world = rb.World()
    low = world.add_body(rb.Box((0.1, 0.1, 0.1)), type="static")
    high = world.add_body(rb.Box((0.1, 0.2, 0.1)), mass=1.0, position=(0.1, 0.0, 0.2))
    contacts = rb.find_contacts(high, low, margin=1e-9)
    points = sorted(map(tuple, np.round(contacts["point"], 12)))
    assert points == [(0.0, -0.1, 0.1), (0.0, 0.1, 0.1), (0.1, -0.1, 0.1), (0.1, 0.1, 0.1)]


@pytest.mark.parametrize("on_box", [False, True])
def test_curved_surfaces_are_smooth(on_box):
    world, _body = resting(rb.Sphere(0.2), (0.1, 0.2, 0.2), (0, 0, 0, 1), Stage(), on_box)
    world.step()
    assert [Kind(k) for k in world.contacts["kind"]] == [Kind.SMOOTH]
    np.testing.assert_allclose(world.contacts["point"][0], (0.1, 0.2, 0), atol=1e-14)


def test_feature_ids_stay_while_a_box_slides():
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.2)
    world.add_body(
        rb.Box((0.1, 0.1, 0.05)),
        mass=1.0,
        position=(0, 0, 0.05),
        linear_velocity=(1, 0.3, 0),
        angular_velocity=(0, 0, 2),
        friction=0.2,
    )
    world.step()
    features = set(world.contacts["feature"])
    for _ in range(200):
        world.step()
        assert set(world.contacts["feature"]) == features


def test_rows_name_the_bodies_as_documented():
    """Static bodies are B; of two dynamic ones A is the higher row; the normal points from B to A."""
    world = rb.World()
    top = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.3))
    low = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1))
    ground = world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    world.step()
    contacts = world.contacts
    on_ground = contacts[contacts["body_b"] == ground.row]
    between = contacts[contacts["body_b"] != ground.row]
    assert len(on_ground) == len(between) == 4
    assert set(on_ground["body_a"]) == {low.row}
    assert set(between["body_a"]) == {low.row} and set(between["body_b"]) == {top.row}
    np.testing.assert_allclose(between["normal"], np.tile((0, 0, -1), (4, 1)), atol=1e-14)
    assert (between["force"][:, 2] < 0).all()  # on A, the lower box: downwards
