"""An open mesh is a sheet with two sides: bodies rest on either, and none passes it at 100 m/s, however
it is triangulated. A particle has no side while it lies on a sheet: it meets the front only."""

import numpy as np
import pytest

import rb_physics as rb
from rb_physics import _core as core

FLAT = rb.TriangleMesh([(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)], [(0, 1, 2), (0, 2, 3)])
SHAPES = {
    "particle": lambda rng: rb.Particle(),
    "sphere": lambda rng: rb.Sphere(0.002),
    "box": lambda rng: rb.Box((0.004, 0.003, 0.005)),
    "capsule": lambda rng: rb.Capsule(0.002, 0.004),
    "cylinder": lambda rng: rb.Cylinder(0.003, 0.004),
    "hull": lambda rng: rb.ConvexHull(0.004 * rng.normal(size=(10, 3))),
}


def _crumpled(rng):
    """5 x 5 vertices about the plane x = 0, seen from +x."""
    grid = np.linspace(-1, 1, 5)
    vertices = [(0.05 * rng.normal(), y, z) for y in grid for z in grid]
    corners = [5 * i + j for i in range(4) for j in range(4)]
    return rb.TriangleMesh(
        vertices, [t for a in corners for t in ((a, a + 6, a + 1), (a, a + 5, a + 6))]
    )


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("sheet", ["flat", "crumpled"])
def test_no_body_passes_a_sheet(sheet, side, shape):
    if shape == "particle" and side == -1:
        pytest.skip("a particle meets the front only")
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world = rb.World(dt=5e-3, gravity=(0, 0, 0))
        mesh = FLAT if sheet == "flat" else _crumpled(rng)
        world.add_body(mesh, type="static", name="sheet")
        start = 0.25 + 0.5 * rng.random()
        aim, aside = rng.uniform(-0.4, 0.4, 2), rng.uniform(-30, 30, 2) * rng.integers(2)
        turning = {} if shape == "particle" else {"angular_velocity": rng.uniform(-200, 200, 3)}
        body = world.add_body(
            SHAPES[shape](rng),
            mass=0.01,
            position=(side * start, *(aim - aside * start / 100)),
            linear_velocity=(-100 * side, *aside),
            name="bullet",
            restitution=float(rng.choice([0, 0.5, 1])),
            **turning,
        )
        for _ in range(6):
            world.step()
            x, y, z = body.com_position
            if max(abs(y), abs(z)) < 0.9:
                # The crumpled sheet is nowhere more than four standard deviations from its plane.
                assert x * side > (-1e-6 if sheet == "flat" else -0.2), seed


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder", "hull"])
def test_the_sides_are_alike(kind):
    """Contacts, distance and contact time from behind are those with the sheet turned over."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        shape = SHAPES[kind](rng)
        size = core.characteristic_size(shape)
        mesh = _crumpled(rng)
        over = rb.TriangleMesh(mesh.vertices, np.array(mesh.triangles)[:, ::-1])
        # A point of a triangle, and the shape about as far behind it as it is large.
        corners = mesh.vertices[mesh.triangles[rng.integers(32)]]
        weights = rng.dirichlet((2, 2, 2))
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        place = weights @ corners - rng.uniform(0.2, 1.3) * size * normal
        turn = rng.normal(size=4)
        found = []
        for surface in (mesh, over):
            world = rb.World(gravity=(0, 0, 0))
            sheet = world.add_body(surface, type="static", name="sheet")
            body = world.add_body(
                shape,
                mass=1.0,
                name="body",
                position=place,
                orientation=turn / np.linalg.norm(turn),
            )
            away = world.add_body(
                shape,
                mass=1.0,
                name="away",
                position=place - 3 * size * normal,
                linear_velocity=10 * normal,
            )
            contacts = rb.find_contacts(body, sheet)
            assert len(contacts) == 0 or (contacts["normal"] @ normal < 0.9).all()
            found.append(
                (
                    np.sort(contacts["separation"]),
                    rb.distance(body, sheet).distance,
                    rb.time_of_impact(away, sheet, 1.0),
                )
            )
        np.testing.assert_allclose(found[0][0], found[1][0], rtol=0, atol=1e-12)
        # A triangle counts as 1e-6 of its size thick behind, where a penetrating shape gets out.
        assert found[0][1] == pytest.approx(found[1][1], abs=1e-12)
        assert found[0][2] == pytest.approx(found[1][2], abs=1e-12)


def test_a_box_rests_on_either_side():
    for turned in (False, True):
        corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        triangles = [(0, 1, 2), (0, 2, 3)]
        world = rb.World()
        world.add_body(
            rb.TriangleMesh(corners, [t[::-1] for t in triangles] if turned else triangles),
            type="static",
            name="sheet",
        )
        box = world.add_body(
            rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0.2, 0.1, 0.1), name="box"
        )
        world.step(200)
        np.testing.assert_allclose(box.position, (0.2, 0.1, 0.1), rtol=0, atol=1e-12)
        assert len(world.contacts) == 4


@pytest.mark.parametrize("shape", [s for s in SHAPES if s != "particle"])
def test_a_body_in_a_sheet_goes_out_on_its_side(shape):
    """Never along the sheet: its inner edges are none."""
    octahedron = core.ConvexHull(0.004 * np.vstack([np.eye(3), -np.eye(3)]))
    body = octahedron if shape == "hull" else SHAPES[shape](np.random.default_rng(1))
    for seed in range(200):
        rng = np.random.default_rng(seed)
        turn = rng.normal(size=4)
        side = 1 if seed % 2 else -1
        # About the diagonal, the centre less than half a size off the sheet.
        along = rng.uniform(-0.8, 0.8)
        place = (side * rng.uniform(1e-4, 1e-3), along + rng.uniform(-1e-3, 1e-3), along)
        found = core.find_contacts(
            body, place, turn / np.linalg.norm(turn), FLAT, (0, 0, 0), (0, 0, 0, 1), 0.0
        )
        assert len(found["separation"]) > 0
        np.testing.assert_allclose(
            found["normal"], [[side, 0, 0]] * len(found["normal"]), atol=1e-15
        )
        distance, _, _, normal = core.distance(
            body, place, turn / np.linalg.norm(turn), FLAT, (0, 0, 0), (0, 0, 0, 1)
        )
        assert distance == found["separation"].min()
        np.testing.assert_allclose(normal, (side, 0, 0), atol=1e-15)
