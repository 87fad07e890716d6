"""What a user may hand over by mistake, at any size: a clear error, or a finite answer that separates."""

import itertools

import numpy as np
import pytest

import rb_physics as rb

UPRIGHT = (0, 0, 0, 1)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
LINE = np.outer(np.linspace(0, 1, 7), (1.0, 2.0, -1.0))
DISK = np.array([[np.cos(t), np.sin(t), 0.3] for t in np.linspace(0, 6, 9)])


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e3])
@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda s: rb.ConvexHull(s * DISK), "flat|plane"),
        (lambda s: rb.ConvexHull(s * LINE), "line"),
        (lambda s: rb.ConvexHull(s * np.ones((5, 3))), "coincide"),
        (lambda s: rb.ConvexHull(s * CUBE[[0, 1, 2, 0, 1, 2]]), "4 points"),
        (lambda s: rb.ConvexHull(s * CUBE[:3]), "4 points"),
        (lambda s: rb.TriangleMesh(s * LINE[:3], [(0, 1, 2)]), "no area"),
        (lambda s: rb.TriangleMesh(s * CUBE, [*TRIANGLES, (0, 1, 1)]), "no area"),
        (lambda s: rb.TriangleMesh(s * CUBE, [t[::-1] for t in TRIANGLES]), "inside out"),
        (lambda s: rb.TriangleMesh(s * CUBE, [TRIANGLES[0][::-1], *TRIANGLES[1:]]), "winding|way"),
    ],
)
def test_degenerate_geometry_is_refused(make, words, scale):
    with pytest.raises(rb.SceneError, match=words):
        make(scale)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e3])
def test_points_given_twice_change_nothing(scale):
    rng = np.random.default_rng(0)
    points = scale * rng.normal(size=(12, 3))
    once, twice = rb.ConvexHull(points), rb.ConvexHull(np.vstack([points, points[::-1], points]))
    np.testing.assert_array_equal(once.points, twice.points)


def test_an_open_mesh_is_taken_but_has_no_mass():
    world = rb.World()
    sheet = rb.TriangleMesh(CUBE, TRIANGLES[:-1])
    assert not sheet.closed
    world.add_body(sheet, type="static", name="open")
    with pytest.raises(rb.SceneError, match="dynamic"):
        world.add_body(sheet, mass=1.0, name="moving")


def _shape(name, size):
    if name == "sphere":
        return rb.Sphere(size)
    if name == "box":
        return rb.Box((size, 0.7 * size, 0.5 * size))
    if name == "capsule":
        return rb.Capsule(0.5 * size, 0.7 * size)
    if name == "cylinder":
        return rb.Cylinder(0.6 * size, size)
    if name == "hull":
        return rb.ConvexHull(size * np.random.default_rng(3).normal(size=(12, 3)))
    bars = [
        (rb.Box((size, 0.3 * size, 0.3 * size)), (0, 0, 0), UPRIGHT),
        (rb.Box((0.3 * size, size, 0.3 * size)), (0, 0, 0), UPRIGHT),
    ]
    return rb.Compound(bars)


NAMES = ["sphere", "box", "capsule", "cylinder", "hull", "compound"]
ORDERED_PAIRS = list(itertools.product(NAMES, NAMES))


def part_from_inside(first, second, seed):
    """Two bodies of 1e-4 to 1e3 m, one up to 1e4 times the other's size, concentric or deep inside."""
    rng = np.random.default_rng(seed)
    large = 10 ** rng.uniform(-4, 3)
    small = max(large / 10 ** rng.uniform(0, 4), 1e-4)
    turn = rng.normal(size=4)
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    a = world.add_body(_shape(first, large), density=1000.0, name="a")
    b = world.add_body(
        _shape(second, small),
        density=1000.0,
        name="b",
        orientation=turn / np.linalg.norm(turn) if seed % 3 else UPRIGHT,
        position=small * rng.normal(size=3) if seed % 3 == 2 else (0, 0, 0),
    )
    world.step(60)
    assert np.isfinite(world.positions).all()
    assert np.isfinite(world.orientations).all()
    assert world.kinetic_energy <= 1e-12  # no energy comes from it
    # What position correction may leave of the small one, and rounding of the large one.
    assert rb.distance(a, b).distance >= -0.02 * small - 1e-12 * large, (seed, large, small)


@pytest.mark.parametrize("names", ORDERED_PAIRS, ids="-".join)
def test_bodies_that_start_inside_each_other_part(names):
    for seed in range(3):
        part_from_inside(*names, seed)


@pytest.mark.soak
@pytest.mark.parametrize("names", ORDERED_PAIRS, ids="-".join)
def test_bodies_that_start_inside_each_other_part_at_any_size(names):
    for seed in range(200):
        part_from_inside(*names, seed)


GROUNDS = {
    "half_space": lambda size: (rb.HalfSpace((0, 0, 1), 0.0), (0, 0, 0)),
    "box": lambda size: (rb.Box((size, size, size)), (0, 0, -size)),
    "mesh": lambda size: (rb.TriangleMesh(size * CUBE, TRIANGLES), (0, 0, -size)),
    "sheet": lambda size: (
        rb.TriangleMesh(size * CUBE[[0, 4, 6, 2]] * [1, 1, 0], [(0, 1, 2), (0, 2, 3)]),
        (0, 0, 0),
    ),
    "height_field": lambda size: (rb.HeightField(np.zeros((3, 3)), size), (-size, -size, 0)),
}


@pytest.mark.parametrize("size", [1e-4, 0.1, 1e3])
@pytest.mark.parametrize("ratio", [3.0, 1e4])
@pytest.mark.parametrize("ground", GROUNDS)
def test_bodies_of_any_size_rest_on_any_ground(ground, ratio, size):
    """Gravity and dt are scaled with the size: 300 steps that are the same at any."""
    for name, height in (("sphere", 1.0), ("box", 0.5), ("capsule", 1.2), ("cylinder", 1.0)):
        world = rb.World(gravity=(0, 0, -9.81 * size), dt=5e-3)
        surface, at = GROUNDS[ground](ratio * size)
        world.add_body(surface, type="static", name="ground", position=at)
        body = world.add_body(
            _shape(name, size),
            density=1000.0,
            name=name,
            position=(0.1 * size, 0.2 * size, (height + 0.02) * size),
        )
        world.step(300)
        # To the touch distance of the ground, 1e-9 of the body, and rounding of the larger one.
        assert body.position[2] == pytest.approx(height * size, abs=(1e-8 + 1e-14 * ratio) * size)
        assert world.stats.queries_capped == 0


def test_every_cap_reports_itself():
    """Work, events and searches that were cut short are counted in world.stats."""
    world = rb.World(dt=5e-3, max_work=4)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground")
    for k in range(5):
        world.add_body(
            rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1 + 0.2 * k), name=f"box_{k}"
        )
    world.step()
    assert world.stats.capped > 0
    assert world.stats.residual > 1e-13

    world = rb.World(dt=5e-3, max_events=1, gravity=(0, 0, 0))
    for k, sign in enumerate((-1, 1)):
        world.add_body(
            rb.Box((0.0005, 1, 1)), type="static", position=(0.05 * sign, 0, 0), name=f"wall_{k}"
        )
    ball = world.add_body(
        rb.Sphere(0.004), mass=0.01, linear_velocity=(500, 0, 0), restitution=1.0, name="ball"
    )
    world.step()  # 25 bounces
    assert world.stats.capped == 1
    assert world.stats.waits == 1
    assert abs(ball.position[0]) < 0.05
