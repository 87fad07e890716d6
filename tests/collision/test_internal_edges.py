"""Sliding over the seams of a flat floor made of pieces: no bump, at any size and heading."""

import itertools

import numpy as np
import pytest

import rb_physics as rb
from tests import oracles

HEADINGS = [0.0, 7.0, 45.0, 83.0]  # degrees from the x axis
SEAM_FREE = 1e-9  # sideways over normal impulse


LEVEL = (0.0, 0.0, 0.0, 1.0)
LYING = (0.0, 0.5**0.5, 0.0, 0.5**0.5)  # the z axis of the shape along x


def hull_of_box(half_extents) -> rb.ConvexHull:
    corners = np.array(list(itertools.product((-1, 1), repeat=3)))
    return rb.ConvexHull(corners * np.asarray(half_extents))


def quarters(size: float, make=rb.Box, depths=(1.0, 1.0, 1.0, 1.0)) -> list:
    """(shape, position) of four pieces whose tops make one plane z = 0."""
    half = 5 * size
    corners = itertools.product((-1, 1), repeat=2)
    return [
        (make((half, half, d * size)), np.array((x * half, y * half, -d * size)))
        for (x, y), d in zip(corners, depths, strict=True)
    ]


def mosaic(size: float) -> list:
    """Pieces smaller than what slides over them."""
    half = 0.31 * size
    return [
        (rb.Box((half, half, 0.2 * size)), np.array((i * half, j * half, -0.2 * size)))
        for i in range(-31, 32, 2)
        for j in range(-15, 16, 2)
    ]


def sill(size: float) -> list:
    """A half-space, a narrow box let into it and a wide one."""
    return [
        (rb.HalfSpace((0, 0, 1), 0.0), np.zeros(3)),
        (rb.Box((0.05 * size, 5 * size, size)), np.array((-0.5 * size, 0, -size))),
        (rb.Box((5 * size, 5 * size, size)), np.array((5 * size, 0, -size))),
    ]


def tiles(world: rb.World, size: float) -> None:
    for k, (shape, position) in enumerate(quarters(size)):
        world.add_body(shape, type="static", name=f"tile{k}", position=position, friction=0.0)


def mesh(world: rb.World, size: float) -> None:
    """A flat mesh of uneven triangles."""
    rng = np.random.default_rng(8)
    lines = np.linspace(-10 * size, 10 * size, 12)
    x, y = np.meshgrid(lines, lines, indexing="ij")
    inner = np.zeros_like(x)
    inner[1:-1, 1:-1] = 0.4 * (lines[1] - lines[0])
    x = x + inner * rng.uniform(-1, 1, x.shape)
    y = y + inner * rng.uniform(-1, 1, y.shape)
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    triangles = []
    for i in range(11):
        for j in range(11):
            a, b, c, d = i * 12 + j, (i + 1) * 12 + j, (i + 1) * 12 + j + 1, i * 12 + j + 1
            triangles += [(a, b, c), (a, c, d)] if rng.integers(2) else [(a, b, d), (b, c, d)]
    world.add_body(rb.TriangleMesh(vertices, triangles), type="static", name="floor", friction=0.0)


FLOORS = {"tiles": tiles, "mesh": mesh}


def sliders(size: float) -> dict:
    """(shape, height of its origin on the floor, orientation)."""
    half = 0.5 * size
    return {
        "box": (rb.Box((size, 0.7 * size, half)), half, LEVEL),
        "ball": (rb.Sphere(size), size, LEVEL),
        "cylinder": (rb.Cylinder(0.6 * size, half), half, LEVEL),
        "roller": (rb.Cylinder(half, 0.8 * size), half, LYING),
        "capsule": (rb.Capsule(half, 0.8 * size), half, LYING),
        "hull": (hull_of_box((size, 0.7 * size, half)), half, LEVEL),
        "compound": (
            rb.Compound(
                [(rb.Box((half, 0.4 * size, half)), (x * half, 0, 0), LEVEL) for x in (-1, 1)]
            ),
            half,
            LEVEL,
        ),
    }


def slide(world: rb.World, name: str, size: float, heading: float, steps: int, turn=LEVEL) -> None:
    """Slides over the origin of a floor turned by `turn`, and checks that nothing is felt."""
    axes = oracles.rotation(np.asarray(turn))
    shape, height, orientation = sliders(size)[name]
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    start = -2 * size * ahead + 0.013 * size * np.array([-ahead[1], ahead[0], 0])
    velocity = axes @ (4000 / steps * size * ahead)
    speed = np.linalg.norm(velocity)
    body = world.add_body(
        shape,
        mass=1.0,
        name="slider",
        position=axes @ (start + (0, 0, height)),
        orientation=product(turn, orientation),
        linear_velocity=velocity,
        friction=0.0,
    )
    for _ in range(steps):
        world.step()
        impulses = world.contacts["impulse"] @ axes
        sideways, normal = np.abs(impulses[:, :2]), impulses[:, 2].sum()
        assert (sideways <= SEAM_FREE * normal).all(), (heading, sideways.max())
        assert np.abs(impulses.sum(axis=0)[:2]).max() <= SEAM_FREE * normal
    assert np.abs(body.linear_velocity - velocity).max() <= SEAM_FREE * speed
    assert np.abs(body.angular_velocity).max() <= SEAM_FREE * speed / size
    assert abs((axes.T @ body.position)[2] - height) <= 1e-9 * size  # the touch distance


def product(p, q) -> np.ndarray:
    """Quaternion of the rotation q followed by p."""
    p, q = np.asarray(p), np.asarray(q)
    vector = p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3])
    return np.array([*vector, p[3] * q[3] - p[:3] @ q[:3]])


@pytest.mark.parametrize("size", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("shape", ["box", "ball", "cylinder"])
@pytest.mark.parametrize("floor", FLOORS)
def test_no_seam_is_felt(floor, shape, size):
    for heading in np.radians(HEADINGS):
        world = rb.World(dt=1e-3, gravity=(0, 0, -9.81))
        FLOORS[floor](world, size)
        slide(world, shape, size, heading, 500)


PIECES = {
    "boxes": quarters,
    "hulls": lambda size: quarters(size, hull_of_box),
    "unequal depths": lambda size: quarters(size, rb.Box, (0.3, 1.0, 2.0, 0.7)),
    "mosaic": mosaic,
    "sill": sill,
}


@pytest.mark.parametrize("shape", sliders(1.0))
@pytest.mark.parametrize("pieces", PIECES)
@pytest.mark.parametrize(
    "how", ["level", "off by rounding", "turned", "one compound", "event stepper"]
)
def test_floor_of_pieces(pieces, shape, how):
    size = 0.1
    rng = np.random.default_rng(3)
    turn = oracles.random_orientation(rng) if how == "turned" else np.array(LEVEL)
    axes = oracles.rotation(turn)
    floor = PIECES[pieces](size)
    if how == "off by rounding":
        floor = [(s, p + (0, 0, rng.uniform(-1e-12, 1e-12))) for s, p in floor]
    for heading in np.radians(HEADINGS[1::2]):
        world = rb.World(
            dt=1e-3,
            gravity=axes @ (0, 0, -9.81),
            stepper="event" if how == "event stepper" else "fixed",
        )
        if how == "one compound" and pieces != "sill":  # half-spaces stand alone
            parts = [(s, p, LEVEL) for s, p in floor]
            world.add_body(rb.Compound(parts), type="static", name="floor", friction=0.0)
        else:
            for k, (piece, at) in enumerate(floor):
                world.add_body(
                    piece,
                    type="static",
                    name=f"piece{k}",
                    position=axes @ at,
                    orientation=turn,
                    friction=0.0,
                )
        slide(world, shape, size, heading, 150, turn)


def course(floor, shape, size=0.1) -> np.ndarray:
    """Positions and velocities while a body with friction slides or rolls over a floor."""
    world = rb.World(dt=1e-3)
    for k, (piece, at) in enumerate(floor):
        world.add_body(piece, type="static", name=f"piece{k}", position=at, friction=0.3)
    form, height, orientation = sliders(size)[shape]
    body = world.add_body(
        form,
        mass=1.0,
        name="slider",
        position=(-0.19, -0.08, height),
        orientation=product((0, 0, 0.15, (1 - 0.15**2) ** 0.5), orientation),
        linear_velocity=(1.4, 0.6, 0),
        friction=0.3,
    )
    states = []
    for _ in range(300):
        world.step()
        states.append([body.position, body.linear_velocity, body.angular_velocity * size])
    return np.array(states)


@pytest.mark.parametrize("shape", ["box", "ball", "cylinder", "hull", "compound"])
@pytest.mark.parametrize("pieces", ["boxes", "hulls", "mosaic"])
def test_friction_on_pieces_is_that_on_one_floor(pieces, shape):
    whole = [(rb.Box((2, 2, 0.1)), (0, 0, -0.1))]
    apart = np.abs(course(PIECES[pieces](0.1), shape) - course(whole, shape))
    assert apart.max() <= 1e-12  # rounding of 300 steps


@pytest.mark.parametrize("off", [0.0, 1e-12])
def test_a_particle_that_stops_over_a_seam(off):
    """At the end of some steps it is exactly over the line between two pieces."""
    world = rb.World(dt=2.0**-10)
    rng = np.random.default_rng(3)
    for k in range(8):
        world.add_body(
            rb.Box((2.0**-5, 1, 0.1)),
            type="static",
            name=f"piece{k}",
            position=(k * 2.0**-4, 0, -0.1 + rng.uniform(-off, off)),
            friction=0.0,
        )
    particle = world.add_body(
        rb.Particle(),
        mass=1.0,
        name="particle",
        position=(-(2.0**-6), 0, 2 * off),
        linear_velocity=(1, 0, 0),
        friction=0.0,
    )
    world.step(440)
    assert abs(particle.linear_velocity[0] - 1.0) <= SEAM_FREE
    assert abs(particle.position[2]) <= 1e-9  # the touch distance


def test_a_step_is_felt():
    """A piece that stands out by more than the touch distance stops what runs into it."""
    world = rb.World(dt=1e-3)
    for name, x, z in (("low", -0.5, -0.1), ("high", 0.5, -0.1 + 1e-4)):
        world.add_body(
            rb.Box((0.5, 0.5, 0.1)), type="static", name=name, position=(x, 0, z), friction=0.0
        )
    body = world.add_body(
        rb.Box((0.05, 0.05, 0.05)),
        mass=1.0,
        name="slider",
        position=(-0.2, 0, 0.05),
        linear_velocity=(1, 0, 0),
        friction=0.0,
    )
    world.step(160)
    assert body.linear_velocity[0] < 0.5  # it trips: the rest of the motion turns it


def test_a_gap_between_level_pieces_is_felt():
    """A ball drops into a gap, and its far edge, level with the near one, stops it."""
    world = rb.World(dt=1e-3)
    for name, x in (("near", -0.5), ("far", 0.6)):
        world.add_body(
            rb.Box((0.5, 0.5, 0.1)), type="static", name=name, position=(x, 0, -0.1), friction=0.0
        )
    ball = world.add_body(
        rb.Sphere(0.06),
        mass=1.0,
        name="ball",
        position=(-0.1, 0, 0.06),
        linear_velocity=(0.3, 0, 0),
        friction=0.0,
    )
    world.step(2000)
    # Between two edges 0.1 m apart: sqrt(r^2 - 0.05^2) above them.
    assert ball.position[2] == pytest.approx((0.06**2 - 0.05**2) ** 0.5, abs=1e-6)
    assert ball.position[0] == pytest.approx(0.05, abs=1e-6)
