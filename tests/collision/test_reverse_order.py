"""Bodies added in reverse order give the mirrored contact set, bit for bit, for every pair of shapes."""

import itertools

import numpy as np
import pytest

import rb_physics as rb
from tests import oracles

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
POINTS = np.random.default_rng(4).normal(size=(12, 3)) * (0.2, 0.25, 0.3)
MOVING = {
    "particle": rb.Particle(),
    "sphere": rb.Sphere(0.3),
    "box": rb.Box((0.2, 0.25, 0.3)),
    "capsule": rb.Capsule(0.15, 0.25),
    "cylinder": rb.Cylinder(0.25, 0.2),
    "hull": rb.ConvexHull(POINTS),
    "compound": rb.Compound(
        [
            (rb.Box((0.3, 0.1, 0.1)), (0, 0, 0), (0, 0, 0, 1)),
            (rb.Cylinder(0.1, 0.2), (0.2, 0, 0.2), (0, 0, 0, 1)),
            (rb.Sphere(0.15), (-0.2, 0, 0.1), (0, 0, 0, 1)),
        ]
    ),
}
STATIC = {
    "half_space": rb.HalfSpace((0, 0, 1), 0.0),
    "mesh": rb.TriangleMesh(
        0.4 * CUBE, [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    ),
    "height_field": rb.HeightField(0.2 * np.random.default_rng(5).random((6, 6)), 0.2),
}
PAIRS = [
    pair
    for pair in itertools.product(MOVING, {**MOVING, **STATIC})
    if pair != ("particle", "particle")  # one inside the other: nothing tells A from B
]


def place(rng, name, spread):
    """Near the origin; static shapes lie at it, turned as well."""
    position = rng.uniform(-spread, spread, 3)
    orientation = (0, 0, 0, 1) if name == "particle" else oracles.random_orientation(rng)
    return position, orientation


def world_of(bodies) -> rb.World:
    world = rb.World(gravity=(0, 0, 0))
    for label, name, (position, orientation) in bodies:
        shape = {**MOVING, **STATIC}[name]
        kind = {"type": "static"} if name in STATIC else {"mass": 1.0}
        world.add_body(shape, name=label, position=position, orientation=orientation, **kind)
    return world


def check_mirrored(there, back):
    """The same points with A and B exchanged, in any order of points, to the bit."""
    assert len(there) == len(back)

    def rows(found, sign):
        return sorted(
            (float(c["separation"]), *map(float, c["point"]), *(sign * c["normal"] + 0.0).tolist())
            for c in found
        )

    assert rows(there, 1.0) == rows(back, -1.0)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_pairs(names):
    met = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        spread = rng.choice([0.0, 0.1, 0.4])
        bodies = [
            (label, name, place(rng, name, spread)) for label, name in zip("ab", names, strict=True)
        ]
        one, other = world_of(bodies), world_of(bodies[::-1])
        there = rb.find_contacts(one["a"], one["b"], 0.05)
        check_mirrored(there, rb.find_contacts(one["b"], one["a"], 0.05))  # asked the other way
        check_mirrored(there, rb.find_contacts(other["b"], other["a"], 0.05))  # added the other way
        met += len(there)
        d = rb.distance(one["a"], one["b"])
        e = rb.distance(other["b"], other["a"])
        assert d.distance == e.distance
        assert (d.normal == -e.normal).all()
        assert (d.point_a == e.point_b).all()
        assert (d.point_b == e.point_a).all()
    assert met > 0 or "particle" in names


def test_a_whole_scene():
    """A hundred resting bodies, stepped: the contact sets of both orders name the same points."""
    scene = rb.load_scene("hundred_bodies").build()
    world = rb.World()
    for body in reversed(scene.bodies):
        kind = {"type": "static"} if body.type == "static" else {"mass": body.mass}
        world.add_body(body.shape, name=body.name, position=body.position, **kind)
    scene.step()
    world.step()
    last = len(world.bodies) - 1

    def rows(contacts, row_of):
        found = []
        for c in contacts:
            a, b = row_of(int(c["body_a"])), row_of(int(c["body_b"]))
            sign = 1.0 if a < b else -1.0
            found.append((min(a, b), max(a, b), *np.round(c["point"], 9), *(sign * c["normal"])))
        return np.array(sorted(found))

    there = rows(scene.contacts, lambda row: row)
    back = rows(world.contacts, lambda row: last - row)
    assert len(there) > 300
    # The step moves the bodies by impulses whose sums are rounded in another order.
    assert np.abs(there - back).max() <= 1e-12
