"""Continuous collision (the whole simulation): nothing passes through a wall of 1 mm at 100 m/s with
steps of 5 ms, for every convex shape against every wall, spinning."""

import numpy as np
import pytest

import rb_physics as rb

TURNED = (0, np.sqrt(0.5), 0, np.sqrt(0.5))  # axis z -> x
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
THIN = CORNERS * [0.0005, 1, 1]
WALLS = {
    "box": (rb.Box((0.0005, 1, 1)), (0, 0, 0, 1)),
    "hull": (rb.ConvexHull(THIN), (0, 0, 0, 1)),
    "cylinder": (rb.Cylinder(1.0, 0.0005), TURNED),
    "half_space": (rb.HalfSpace((-1, 0, 0), 0.0), (0, 0, 0, 1)),
    "mesh": (
        rb.TriangleMesh(THIN, [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]),
        (0, 0, 0, 1),
    ),
}
BULLETS = {
    "particle": rb.Particle(),
    "sphere": rb.Sphere(0.004),
    "box": rb.Box((0.004, 0.003, 0.005)),
    "capsule": rb.Capsule(0.002, 0.004),
    "cylinder": rb.Cylinder(0.003, 0.004),
    "hull": rb.ConvexHull(0.004 * np.vstack([np.eye(3), -np.eye(3)])),
}


@pytest.mark.parametrize("bullet", BULLETS)
@pytest.mark.parametrize("wall", WALLS)
def test_nothing_passes_a_thin_wall(wall, bullet):
    shape, orientation = WALLS[wall]
    for start in (-0.3, -0.4, -0.513, -0.7):
        world = rb.World(dt=5e-3, gravity=(0, 0, 0))
        world.add_body(shape, type="static", name="wall", orientation=orientation)
        spin = {} if bullet == "particle" else {"angular_velocity": (3, 50, 10)}
        body = world.add_body(
            BULLETS[bullet],
            mass=0.01,
            position=(start, 0.1, 0.13),
            linear_velocity=(100, 0, 0),
            name="bullet",
            **spin,
        )
        world.step(10)
        assert body.position[0] <= 0, start
