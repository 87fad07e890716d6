"""Sliding over the seams of a flat floor made of pieces: no bump, at any size and heading."""

import numpy as np
import pytest

import rb_physics as rb

HEADINGS = [0.0, 7.0, 45.0, 83.0]  # degrees from the x axis
SEAM_FREE = 1e-9  # sideways over normal impulse


def tiles(world: rb.World, size: float) -> None:
    """Four static boxes whose tops make one plane z = 0."""
    half = 5 * size
    for x in (-1, 1):
        for y in (-1, 1):
            name = f"tile{'_m' if x < 0 else '_p'}{'_m' if y < 0 else '_p'}"
            world.add_body(
                rb.Box((half, half, size)),
                type="static",
                name=name,
                position=(x * half, y * half, -size),
                friction=0.0,
            )


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
    return {
        "box": (rb.Box((size, 0.7 * size, 0.5 * size)), 0.5 * size),
        "ball": (rb.Sphere(size), size),
        "cylinder": (rb.Cylinder(0.6 * size, 0.5 * size), 0.5 * size),
    }


@pytest.mark.parametrize("size", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("shape", ["box", "ball", "cylinder"])
@pytest.mark.parametrize(
    "floor",
    [
        "mesh",
        # Just before the seam the side of the next tile is the nearest face, across a gap: the slider
        # runs into it although the two overlap in a strip of no height. A ball meets the edge in a
        # graze, whose time (and so the normal) is good to the root of rounding, 1e-7.
        pytest.param("tiles", marks=pytest.mark.xfail(reason="sides of level tiles are felt")),
    ],
)
def test_no_seam_is_felt(floor, shape, size):
    for heading in np.radians(HEADINGS):
        world = rb.World(dt=1e-3, gravity=(0, 0, -9.81))
        FLOORS[floor](world, size)
        ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
        body_shape, height = sliders(size)[shape]
        start = -2 * size * ahead + 0.013 * size * np.array([-ahead[1], ahead[0], 0])
        velocity = 8 * size * ahead
        body = world.add_body(
            body_shape,
            mass=1.0,
            name="slider",
            position=start + (0, 0, height),
            linear_velocity=velocity,
            friction=0.0,
        )
        crossed = 0
        for _ in range(500):
            world.step()
            impulse = world.contacts["impulse"].sum(axis=0)
            each = np.abs(world.contacts["impulse"][:, :2])
            normal = world.contacts["impulse"][:, 2].sum()
            assert (each <= SEAM_FREE * normal).all(), (heading, each.max())
            assert np.abs(impulse[:2]).max() <= SEAM_FREE * impulse[2]
            crossed += len(set(world.contacts["body_b"].tolist())) > 1
        assert np.abs(body.linear_velocity - velocity).max() <= SEAM_FREE * np.linalg.norm(velocity)
        assert np.abs(body.angular_velocity).max() <= 1e-9 * 8  # of the speed in sizes per second
        assert abs(body.position[2] - height) <= 1e-9 * size
        if floor == "tiles" and shape != "ball":
            assert crossed > 0  # it stood on several tiles at once
