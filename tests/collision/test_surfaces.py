"""Meshes and height fields: seams are not felt, edges and corners are, bad ones are refused."""

import pickle

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core

IDENTITY = np.array([0, 0, 0, 1.0])
ORIGIN = np.zeros(3)
GROUND = _core.HalfSpace((0, 0, 1), 0.0)
CUBE_VERTICES = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
CUBE_QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE_TRIANGLES = [t for a, b, c, d in CUBE_QUADS for t in ((a, b, c), (a, c, d))]


def grid(heights, spacing):
    """The vertices and triangles of a height field as a mesh, split along the other diagonal."""
    n, m = heights.shape
    vertices = [[i * spacing, j * spacing, heights[i, j]] for i in range(n) for j in range(m)]
    triangles = []
    for i in range(n - 1):
        for j in range(m - 1):
            a = i * m + j
            triangles += [(a, a + m, a + m + 1), (a, a + m + 1, a + 1)]
    return np.array(vertices), triangles


def centred(surface_type):
    """A flat surface of 10 x 10 cells of 0.3 m and where to put it to be centred."""
    heights = np.zeros((11, 11))
    surface = (
        _core.HeightField(heights, 0.3)
        if surface_type == "height_field"
        else _core.TriangleMesh(*grid(heights, 0.3))
    )
    return surface, np.array([-1.5, -1.5, 0.0])


def hull():
    return _core.ConvexHull(np.vstack([0.2 * CUBE_VERTICES, [[0.3, 0, -0.1]]]))


SHAPES = [_core.Sphere(0.1), _core.Box((0.1, 0.2, 0.1)), hull()]


def rows(contacts):
    fields = [contacts["point_a"], contacts["point_b"], contacts["normal"]]
    table = np.hstack([*fields, contacts["separation"][:, None]])
    return sorted(map(tuple, np.round(table, 12)))  # far below the tolerances of contact


@pytest.mark.parametrize("surface_type", ["mesh", "height_field"])
@pytest.mark.parametrize("shape", SHAPES, ids=["sphere", "box", "hull"])
def test_flat_surface_is_a_half_space(surface_type, shape):
    """No inner edge shows: the same points, normals and separations as on the plane, wherever the
    shape stands and however it is turned."""
    rng = np.random.default_rng(0)
    surface, place = centred(surface_type)
    for k in range(100):
        yaw = rng.uniform(0, 7)
        turn = np.array([0, 0, np.sin(yaw), np.cos(yaw)]) if k % 2 else rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        position = np.append(rng.uniform(-0.9, 0.9, 2), 0.1 - rng.choice([1e-9, 1e-4, 2e-2]))
        if k % 5 == 0:  # exactly over the lines of the grid
            position[:2] = 0.3 * np.round(position[:2] / 0.3)
        on_surface = _core.find_contacts(shape, position, turn, surface, place, IDENTITY, 0.01)
        on_plane = _core.find_contacts(shape, position, turn, GROUND, ORIGIN, IDENTITY, 0.01)
        assert rows(on_surface) == rows(on_plane)


@pytest.mark.parametrize("shape", SHAPES, ids=["sphere", "box", "hull"])
def test_sliding_over_seams_pushes_nothing_sideways(shape):
    surface, place = centred("mesh")
    for x in np.linspace(-0.7, 0.7, 701):
        at = (x, 0.37 * x, 0.1 - 1e-9)
        normals = _core.find_contacts(shape, at, IDENTITY, surface, place, IDENTITY, 1e-6)["normal"]
        assert len(normals) > 0
        assert np.abs(normals[:, :2]).max() <= 1e-9  # sideways over normal impulse


def rotated(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def test_closed_mesh_of_a_cube_is_a_box():
    """Distance, intersection and rays are those of the box, on every side and corner."""
    rng = np.random.default_rng(1)
    mesh, box = _core.TriangleMesh(CUBE_VERTICES, CUBE_TRIANGLES), _core.Box((0.5, 0.5, 0.5))
    assert mesh.closed
    here, turn = rng.normal(size=3), rotated(rng)
    for k in range(300):
        shape, position, q = SHAPES[k % 3], here + rng.normal(size=3), rotated(rng)
        d_box = _core.distance(shape, position, q, box, here, turn)
        d_mesh = _core.distance(shape, position, q, mesh, here, turn)
        meet = _core.test_intersection(shape, position, q, mesh, here, turn)
        assert meet == (d_box[0] <= 0)
        if d_box[0] > 0:
            assert d_mesh[0] == pytest.approx(d_box[0], abs=1e-12)  # rounding of coordinates near 1
        origin, direction = here + 2 * rng.normal(size=3), rng.normal(size=3)
        hit_box = _core.ray_cast(box, here, turn, origin, direction)
        hit_mesh = _core.ray_cast(mesh, here, turn, origin, direction)
        assert (hit_box is None) == (hit_mesh is None)
        if hit_box is not None and hit_box[0] > 0:
            assert hit_mesh[0] == pytest.approx(hit_box[0], abs=1e-12)
            np.testing.assert_allclose(hit_mesh[2], hit_box[2], atol=1e-12)


def test_mass_of_a_closed_mesh():
    mesh = _core.TriangleMesh(np.add(CUBE_VERTICES, [3, 0, 0]), CUBE_TRIANGLES)
    mass, center, inertia = _core.unit_density_mass(mesh)
    assert mass == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(center, (3, 0, 0), atol=1e-15)
    np.testing.assert_allclose(inertia, np.eye(3) / 6, atol=1e-15)
    surface, _ = centred("mesh")
    with pytest.raises(ValueError, match="no volume"):
        _core.unit_density_mass(surface)


@pytest.mark.parametrize("offset", [0.0, 0.2, 0.45])
def test_box_overhanging_the_edge_of_a_mesh(offset):
    """The contacts span the overlap, all straight up, none from the side faces."""
    mesh = _core.TriangleMesh(CUBE_VERTICES, CUBE_TRIANGLES)
    box = _core.Box((0.5, 0.4, 0.1))
    for depth in (1e-9, 1e-5):
        at = (offset, 0, 0.6 - depth)
        contacts = _core.find_contacts(box, at, IDENTITY, mesh, ORIGIN, IDENTITY, 1e-4)
        np.testing.assert_array_equal(contacts["normal"], [[0, 0, 1]] * len(contacts["normal"]))
        np.testing.assert_allclose(contacts["separation"], -depth, atol=1e-15)
        span = np.ptp(contacts["point_b"], axis=0)
        np.testing.assert_allclose(span, (1 - offset, 0.8, 0), atol=1e-12)


@pytest.mark.parametrize("surface_type", ["mesh", "height_field"])
def test_ridge_and_valley(surface_type):
    """A box lies on a ridge by its face; a ball in a valley touches both slopes and no edge."""
    ridge = 0.3 - 0.3 * np.abs(np.arange(3) - 1)[:, None] * np.ones((3, 5))
    make = {
        "mesh": lambda h: _core.TriangleMesh(*grid(h, 0.5)),
        "height_field": lambda h: _core.HeightField(h, 0.5),
    }[surface_type]
    box = _core.Box((0.3, 0.3, 0.1))
    contacts = _core.find_contacts(
        box, (0.5, 1, 0.4), IDENTITY, make(ridge), ORIGIN, IDENTITY, 1e-6
    )
    np.testing.assert_allclose(
        contacts["normal"], [[0, 0, 1]] * len(contacts["normal"]), atol=1e-12
    )
    np.testing.assert_allclose(contacts["point_b"][:, 0], 0.5, atol=1e-12)
    assert np.ptp(contacts["point_b"][:, 1]) == pytest.approx(0.6, abs=1e-12)

    cosine = 1 / np.hypot(1, 0.6)
    contacts = _core.find_contacts(
        _core.Sphere(0.2),
        (0.5, 1, 0.2 / cosine),
        IDENTITY,
        make(0.3 - ridge),
        ORIGIN,
        IDENTITY,
        1e-6,
    )
    sine = 0.6 * cosine
    np.testing.assert_allclose(
        sorted(contacts["normal"].tolist()), [(-sine, 0, cosine), (sine, 0, cosine)], atol=1e-12
    )
    np.testing.assert_allclose(contacts["separation"], 0, atol=1e-12)


def test_peak_touches_with_its_vertex():
    heights = np.zeros((5, 5))
    heights[2, 2] = 0.5
    field = _core.HeightField(heights, 1.0)
    contacts = _core.find_contacts(
        _core.Box((0.2, 0.2, 0.1)), (2, 2, 0.6), IDENTITY, field, ORIGIN, IDENTITY, 1e-6
    )
    assert contacts["point_b"].tolist() == [[2, 2, 0.5]]
    np.testing.assert_allclose(contacts["normal"], [[0, 0, 1]], atol=1e-12)


def test_feature_ids_stay_while_resting_and_bodies_may_be_exchanged():
    surface, place = centred("mesh")
    box = _core.Box((0.1, 0.2, 0.1))
    first = _core.find_contacts(box, (0.1, 0.1, 0.1), IDENTITY, surface, place, IDENTITY, 1e-3)
    moved = _core.find_contacts(
        box, (0.1, 0.1, 0.1 - 1e-9), IDENTITY, surface, place, IDENTITY, 1e-3
    )
    assert sorted(first["feature"]) == sorted(moved["feature"])
    assert len(set(first["feature"])) == 4
    other = _core.find_contacts(surface, place, IDENTITY, box, (0.1, 0.1, 0.1), IDENTITY, 1e-3)
    np.testing.assert_array_equal(other["normal"], -first["normal"])
    np.testing.assert_array_equal(other["point_b"], first["point_a"])


@pytest.mark.parametrize("surface_type", ["mesh", "height_field"])
def test_time_of_impact(surface_type):
    surface, place = centred(surface_type)
    for shape in SHAPES:
        fall = _core.Motion(
            position=(0.05, 0.1, 1), linear_velocity=(0.2, 0.1, 0), acceleration=(0, 0, -9.81)
        )
        fixed = _core.Motion(position=place)
        time, _, converged = _core.time_of_impact(shape, fall, surface, fixed, 1.0)
        assert converged
        assert time == pytest.approx(np.sqrt(2 * 0.9 / 9.81), abs=1e-10)
        # Sliding over the seams is no impact.
        slide = _core.Motion(position=(-0.5, 0.1, 0.1), linear_velocity=(1, 0.3, 0))
        assert _core.time_of_impact(shape, slide, surface, fixed, 1.0)[0] is None


def test_bullet_against_a_mesh_wall():
    wall = _core.TriangleMesh(CUBE_VERTICES * [0.001, 2, 2], CUBE_TRIANGLES)
    rng = np.random.default_rng(3)
    for _ in range(20):
        start = rng.uniform(-0.45, -0.05)
        motion = _core.Motion(
            position=(start, *rng.uniform(-0.8, 0.8, 2)), linear_velocity=(100, 0, 0)
        )
        time, _, _ = _core.time_of_impact(_core.Sphere(0.002), motion, wall, _core.Motion(), 0.005)
        assert time == pytest.approx((-start - 0.0025) / 100, abs=1e-12)


def test_rays_on_a_bumpy_height_field():
    rng = np.random.default_rng(4)
    heights = rng.uniform(0, 0.4, (12, 9))
    field = _core.HeightField(heights, (0.25, 0.4))
    vertices = [[i * 0.25, j * 0.4, heights[i, j]] for i in range(12) for j in range(9)]
    triangles = []
    for i in range(11):
        for j in range(8):
            a = i * 9 + j
            triangles += [(a, a + 9, a + 1), (a + 9, a + 10, a + 1)]
    mesh = _core.TriangleMesh(vertices, triangles)
    hits = 0
    for _ in range(500):
        origin = rng.uniform((-1, -1, -1), (4, 4, 2))
        direction = rng.uniform((0, 0, 0), (2.75, 3.2, 0.4)) - origin
        a = _core.ray_cast(field, ORIGIN, IDENTITY, origin, direction)
        b = _core.ray_cast(mesh, ORIGIN, IDENTITY, origin, direction)
        assert (a is None) == (b is None)
        if a is not None:
            hits += 1
            assert a[0] == pytest.approx(b[0], abs=1e-13)
            np.testing.assert_allclose(a[2], b[2], atol=1e-13)
    assert hits > 200


def test_deep_inside_gives_a_finite_answer():
    mesh = _core.TriangleMesh(CUBE_VERTICES, CUBE_TRIANGLES)
    rng = np.random.default_rng(5)
    for k in range(200):
        position = rng.uniform(-0.5, 0.5, 3) if k else ORIGIN
        contacts = _core.find_contacts(
            SHAPES[k % 3], position, rotated(rng), mesh, ORIGIN, IDENTITY, 0.0
        )
        for field in ("point_a", "point_b", "normal", "separation"):
            assert np.isfinite(contacts[field]).all()


TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("vertices", "triangles", "complaint"),
    [
        (TRIANGLE, np.zeros((0, 3), int), "no triangles"),
        (TRIANGLE, [[0, 1, 3]], "an index of a vertex, 0 to 2"),
        (TRIANGLE, [[0, 1, -1]], "an index of a vertex"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], "no area"),
        (TRIANGLE, [[0, 1, 1]], "no area"),
        ([[0, 0, float("nan")], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([*TRIANGLE, [1, 1, 0]], [[0, 1, 2], [1, 2, 3]], "the same way"),
        ([*TRIANGLE, [1, 1, 0], [0, 0, 1]], [[0, 1, 2], [2, 1, 3], [2, 1, 4]], "more than two"),
        (CUBE_VERTICES, [t[::-1] for t in CUBE_TRIANGLES], "inside out"),
        (TRIANGLE, [[0.0, 1.0, 2.0]], "integers"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], r"\(n, 3\)"),
    ],
)
def test_bad_meshes_are_refused(vertices, triangles, complaint):
    with pytest.raises(ValueError, match=complaint):
        _core.TriangleMesh(vertices, triangles)


@pytest.mark.parametrize(
    ("heights", "spacing", "complaint"),
    [
        ([[0, 0]], 1.0, "2 x 2"),
        ([[0, 0], [0, float("inf")]], 1.0, r"heights\[1\]\[1\]"),
        ([[0, 0], [0, 0]], 0.0, "spacing"),
        ([[0, 0], [0, 0]], (1.0, -1.0), "spacing"),
        ([0, 0], 1.0, "shape"),
        ([[0, 0], [0, 0]], "wide", "spacing"),
    ],
)
def test_bad_height_fields_are_refused(heights, spacing, complaint):
    with pytest.raises(ValueError, match=complaint):
        _core.HeightField(heights, spacing)


def test_surfaces_are_values():
    mesh = _core.TriangleMesh(CUBE_VERTICES, CUBE_TRIANGLES)
    field = _core.HeightField(np.arange(6.0).reshape(2, 3), (1, 2))
    for shape in (mesh, field):
        copy = pickle.loads(pickle.dumps(shape))
        assert copy == shape
        assert hash(copy) == hash(shape)
    assert mesh != field
    assert field != _core.HeightField(np.zeros((2, 3)), (1, 2))


def test_repeated_vertices_are_merged():
    """Files of separate triangles (STL) have no shared vertices; the mesh finds its neighbours."""
    soup = CUBE_VERTICES[np.array(CUBE_TRIANGLES)].reshape(-1, 3)
    mesh = _core.TriangleMesh(soup, np.arange(36).reshape(12, 3))
    assert mesh.closed
    assert mesh.vertices.shape == (8, 3)


@pytest.mark.parametrize(
    ("shape", "friction"),
    [
        (rb.Sphere(0.1), 0.3),
        (rb.Box((0.1, 0.1, 0.1)), 0.3),
        (rb.Capsule(0.1, 0.15), 0.0),
        (rb.Cylinder(0.1, 0.1), 0.0),
    ],
    ids=["sphere", "box", "capsule", "cylinder"],
)
@pytest.mark.parametrize("surface_type", ["mesh", "height_field"])
def test_a_body_slides_over_seams_as_on_a_plane(surface_type, shape, friction):
    """The whole simulation: the same motion as on a half-space, no sideways force, the same contact
    ids all the way."""

    def slide(ground, place):
        world = rb.World(dt=2e-3)
        world.add_body(ground, type="static", position=place, name="ground", friction=friction)
        body = world.add_body(
            shape,
            mass=1.0,
            position=(-1, 0.1, 0.1),
            orientation=(np.sqrt(0.5), 0, 0, np.sqrt(0.5)),  # capsule and cylinder lie
            linear_velocity=(2, 0.3, 0),
            name="body",
            friction=friction,
        )
        features = set()
        for _ in range(300):
            world.step()
            features |= set(world.contacts["feature"].tolist())
            assert np.abs(world.contacts["normal"][:, :2]).max(initial=0) == 0
        return body.position, body.linear_velocity, len(features)

    surface, place = centred(surface_type)
    position, velocity, features = slide(surface, place)
    position_0, velocity_0, features_0 = slide(GROUND, ORIGIN)
    # 300 steps of rounding, and of a solver that ends below 1e-13.
    np.testing.assert_allclose(position, position_0, atol=1e-11)
    np.testing.assert_allclose(velocity, velocity_0, atol=1e-11)
    assert features == features_0
