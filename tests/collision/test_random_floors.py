"""Sliding over flat floors of random pieces: boxes, hulls and meshes; static, kinematic, dynamic."""

import itertools

import numpy as np
import pytest

import rb_physics as rb
from tests import oracles
from tests.collision.test_internal_edges import SEAM_FREE, hull_of_box, product, sliders

WIDTH, DEPTH = 4.0, 0.8  # of a floor and of a piece, in sizes of the slider


def cuts(rng, smallest=0.3, largest=2.5):
    """Places at random distances that divide the width of a floor."""
    at = [-WIDTH]
    while at[-1] < WIDTH:
        at.append(at[-1] + rng.uniform(smallest, largest))
    return at


def prism(polygon) -> rb.ConvexHull:
    """Its top is the polygon at z = 0."""
    top = np.column_stack([polygon, np.zeros(len(polygon))])
    return rb.ConvexHull(np.vstack([top, top - (0, 0, DEPTH)]))


def patch(rng, x, y) -> rb.TriangleMesh:
    """A flat rectangle of triangles about a random point inside."""
    inside = [rng.uniform(0.2, 0.8) * (b - a) + a for a, b in (x, y)]
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    vertices = np.column_stack([[*corners, inside], np.zeros(5)])
    return rb.TriangleMesh(vertices, [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])


def rectangles(rng):
    """Rows of unequal rectangles, of every make: (shape, position)."""
    for y in itertools.pairwise(cuts(rng)):
        for x in itertools.pairwise(cuts(rng)):
            half = np.array([x[1] - x[0], y[1] - y[0], DEPTH]) / 2
            center = np.array([np.mean(x), np.mean(y), -DEPTH / 2])
            make = rng.choice(["box", "hull", "mesh"])
            if make == "mesh":
                yield patch(rng, x, y), np.zeros(3)
            else:
                yield (rb.Box if make == "box" else hull_of_box)(half), center


def triangles(rng):
    """Prisms over a grid whose points are moved at random."""
    lines = np.arange(-WIDTH, WIDTH + 1, 2.0)
    x, y = np.meshgrid(lines, lines, indexing="ij")
    points = np.stack([x, y], axis=-1) + rng.uniform(-0.5, 0.5, (*x.shape, 2))
    for i, j in itertools.product(range(len(lines) - 1), repeat=2):
        a, b, c, d = points[i, j], points[i + 1, j], points[i + 1, j + 1], points[i, j + 1]
        for polygon in ((a, b, c), (a, c, d)) if rng.integers(2) else ((a, b, d), (b, c, d)):
            yield prism(polygon), np.zeros(3)


LAYOUTS = {"rectangles": rectangles, "triangles": triangles}


def scaled(shape, size):
    if isinstance(shape, rb.Box):
        return rb.Box(np.multiply(shape.half_extents, size))
    if isinstance(shape, rb.ConvexHull):
        return rb.ConvexHull(np.multiply(shape.points, size))
    return rb.TriangleMesh(np.multiply(shape.vertices, size), shape.triangles)


def body_type(rng, shape) -> str:
    choice = rng.choice(["static", "kinematic", "dynamic"], p=[0.45, 0.25, 0.3])
    return "static" if isinstance(shape, rb.TriangleMesh) else str(choice)


def slide(layout, name, seed, steps=120):
    """Nothing is felt, whatever is at rest below; returns how many pieces were touched."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-2, 1)
    turn = oracles.random_orientation(rng) if rng.integers(2) else np.array([0, 0, 0, 1.0])
    axes = oracles.rotation(turn)
    heading = rng.uniform(0, 2 * np.pi) if rng.integers(3) else 0.5 * np.pi * rng.integers(4)
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    speed = 3.5 * size / (steps * 1e-3)
    if name == "particle":
        shape, height, orientation = rb.Particle(), 0.0, (0, 0, 0, 1)
    else:
        shape, height, orientation = sliders(size)[name]
    start = -2 * size * ahead + rng.uniform(-1, 1, 3) * (size, size, 0)
    world = rb.World(
        dt=1e-3,
        gravity=axes @ (0, 0, -9.81),
        stepper=str(rng.choice(["fixed", "event"])),
    )
    world.add_body(
        rb.HalfSpace((0, 0, 1), -DEPTH * size), type="static", name="ground", orientation=turn
    )
    pieces = list(LAYOUTS[layout](rng))
    place = rng.integers(len(pieces))  # of the slider among them: who is A is a matter of rows
    for k, (piece, at) in enumerate(pieces):
        if k == place:
            body = world.add_body(
                shape,
                mass=10.0 ** rng.uniform(-1, 1) * size**3,
                name="slider",
                position=axes @ (start + (0, 0, height)),
                orientation=product(turn, orientation),
                linear_velocity=speed * (axes @ ahead),
                friction=0.0,
            )
            row = len(world.bodies) - 1
        kind = body_type(rng, piece)
        world.add_body(
            scaled(piece, size),
            type=kind,
            density=1.0 if kind == "dynamic" else None,
            name=f"piece{k}",
            position=axes @ (size * at),
            orientation=turn,
            friction=0.5,
        )
    touched = set()
    for _ in range(steps):
        world.step()
        found = world.contacts
        of_slider = (found["body_a"] == row) | (found["body_b"] == row)
        touched.update(found["body_a"][of_slider], found["body_b"][of_slider])
        impulses = found["impulse"][of_slider] @ axes
        sideways, normal = np.abs(impulses[:, :2]), np.abs(impulses[:, 2]).sum()
        assert (sideways <= SEAM_FREE * normal).all(), sideways.max() / normal
    assert np.abs(axes.T @ body.linear_velocity - speed * ahead).max() <= SEAM_FREE * speed
    assert np.abs(body.angular_velocity).max() <= SEAM_FREE * speed / size
    assert abs((axes.T @ body.position)[2] - height) <= 1e-9 * size  # the touch distance
    return len(touched) - 1


@pytest.mark.parametrize("name", [*sliders(1.0), "particle"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_no_seam_is_felt(layout, name):
    pieces = [slide(layout, name, seed) for seed in range(3)]
    assert max(pieces) >= 3


@pytest.mark.soak
@pytest.mark.parametrize("name", [*sliders(1.0), "particle"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_no_seam_is_felt_on_many_floors(layout, name):
    for seed in range(100, 300):
        slide(layout, name, seed)
