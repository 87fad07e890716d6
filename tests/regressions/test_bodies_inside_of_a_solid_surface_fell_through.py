"""Bodies whose centres start below a height field or inside of a closed mesh are pushed out."""

import numpy as np
import pytest

import rb_physics as rb

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-2, 0)], float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FLOORS = {
    "height field": (rb.HeightField(np.zeros((11, 11)), 0.2), (-1, -1, 0)),
    "closed mesh": (
        rb.TriangleMesh(CORNERS, [t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))]),
        (0, 0, 0),
    ),
}
BODIES = {
    "particle": (rb.Particle(), 0.0),
    "ball": (rb.Sphere(0.1), 0.1),
    "box": (rb.Box((0.1, 0.1, 0.1)), 0.1),
    "capsule": (rb.Capsule(0.05, 0.05), 0.1),
    "cylinder": (rb.Cylinder(0.1, 0.1), 0.1),
    "slabs": (
        rb.Compound([(rb.Box((0.1, 0.1, 0.05)), (0, 0, z), (0, 0, 0, 1)) for z in (-0.05, 0.05)]),
        0.1,
    ),
}


@pytest.mark.parametrize("depth", [1e-3, 0.02, 0.09])
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("floor", FLOORS)
def test_it_comes_to_rest_on_top(floor, body, depth):
    world = rb.World(dt=2e-3)
    surface, at = FLOORS[floor]
    ground = world.add_body(surface, type="static", name="ground", position=at)
    shape, height = BODIES[body]
    thing = world.add_body(shape, mass=1.0, name="thing", position=(0.03, 0.05, -depth))
    assert rb.test_intersection(thing, ground)
    assert rb.distance(thing, ground).distance <= -depth
    assert len(rb.find_contacts(thing, ground)) > 0
    world.step(500)
    assert thing.position[2] == pytest.approx(height, abs=1e-6)  # at rest after 1 s
    assert np.abs(thing.linear_velocity).max() < 1e-6
