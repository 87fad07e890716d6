"""Manifolds of bodies that did not move by a bit are kept: to the bit what a new search finds."""

import numpy as np
import pytest

import rb_physics as rb

BOX = rb.Box((0.1, 0.1, 0.1))


def floor(world):
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="floor")


def apart(**settings):
    """Boxes at rest, each for itself; one of them is pushed now and then."""
    world = rb.World(dt=1e-3, **settings)
    for k in range(20):
        world.add_body(BOX, mass=1.0, position=(0.4 * k, 0, 0.1), name=f"box{k}")
    floor(world)
    return world


def tower(**settings):
    world = rb.World(dt=5e-3, **settings)
    for k in range(6):
        world.add_body(BOX, mass=1.0, position=(0, 0, 0.1 + 0.2 * k), name=f"box{k}")
    floor(world)
    return world


def many_shapes(**settings):
    """Each shape on a slab, and a slab above two of them."""
    world = rb.World(dt=2e-3, **settings)
    shapes = [
        rb.Sphere(0.1),
        rb.Capsule(0.1, 0.1),
        rb.Cylinder(0.1, 0.1),
        rb.ConvexHull(
            0.1 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        ),
        BOX,
        BOX,
    ]
    for k, shape in enumerate(shapes):
        world.add_body(shape, mass=1.0, position=(0.4 * k, 0, 0.201), name=f"box{k}")
    world.add_body(rb.Box((0.4, 0.1, 0.05)), mass=1.0, position=(1.8, 0, 0.36), name="slab")
    world.add_body(rb.Box((3, 1, 0.1)), type="static", position=(1, 0, 0), name="table")
    return world


def tiles(**settings):
    """A box that slides over a floor of tiles and a compound, and comes to rest on a seam."""
    world = rb.World(dt=2e-3, **settings)
    tile = rb.Box((0.25, 0.5, 0.05))
    for k in range(4):
        world.add_body(tile, type="static", position=(0.5 * k, 0, -0.05), name=f"tile{k}")
    two = [(tile, (x, 0, 0), (0, 0, 0, 1)) for x in (-0.25, 0.25)]
    world.add_body(rb.Compound(two), type="static", position=(-0.75, 0, -0.05), name="two")
    world.add_body(BOX, mass=1.0, position=(-0.6, 0, 0.1), linear_velocity=(2, 0, 0), name="box0")
    return world


def carried(**settings):
    """Boxes on a kinematic slab that moves for a while."""
    world = rb.World(dt=2e-3, **settings)
    slab = world.add_body(rb.Box((0.5, 0.5, 0.05)), type="kinematic", name="slab")
    slab.linear_velocity = (0.3, 0, 0)
    for k in range(2):
        world.add_body(BOX, mass=1.0, position=(0, 0, 0.15 + 0.2 * k), name=f"box{k}")
    floor(world)
    return world


def disturb(world, k):
    """What a user may do between two steps."""
    box = world["box0"]
    if k == 60:
        box.apply_impulse((0.3, 0.1, 0.0))
    if k == 75:
        box.position = np.array(box.position) + (0, 0, 1e-3)
    if k == 85:
        box.friction = 0.1
    if k == 90:
        box.apply_wrench((3.0, 0, 0), (0, 0, 0), duration=0.02)
    if k == 100:
        box.linear_velocity = (0, 0, 0)
    if k == 105:
        world.add_body(BOX, mass=1.0, position=(0, 2, 0.2), name="late")
    if k == 112:
        world.remove(world["late"])


@pytest.mark.parametrize(
    ("build", "settings"),
    [
        (apart, {}),
        (apart, {"stepper": "event"}),
        (apart, {"sleeping": True}),
        (apart, {"contact_margin": 0.01}),
        (apart, {"threads": 2}),
        (tower, {}),
        (many_shapes, {}),
        (tiles, {}),
        (carried, {}),
        (carried, {"sleeping": True}),
    ],
)
def test_kept_manifolds_are_those_that_a_search_finds(build, settings):
    kept, searched = build(**settings), build(**settings)
    for k in range(120):
        for world in (kept, searched):
            disturb(world, k)
        searched.restore(searched.save())  # forgets what was looked for
        kept.step()
        searched.step()
        assert kept.state_hash == searched.state_hash, f"step {k}"


def test_what_joins_bodies_that_meet_nobody_moves():
    world = rb.World(dt=1e-3)
    world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 1), name="first")
    world.step(10)
    late = world.add_body(rb.Sphere(0.1), mass=1.0, position=(1, 0, 1), name="late")
    world.step(10)
    assert late.position[2] < 1.0


def test_what_rests_stays_where_it_is():
    world = apart()
    world.step(300)
    before = np.array(world.positions), np.array(world.orientations)
    world.step(300)
    np.testing.assert_array_equal(world.positions, before[0])
    np.testing.assert_array_equal(world.orientations, before[1])


def test_what_creeps_moves():
    """A way of 1e-15 m and a turn of 1e-14 rad a step are motion."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    box = world.add_body(
        BOX, mass=1.0, linear_velocity=(1e-12, 0, 0), angular_velocity=(0, 0, 1e-11), name="box"
    )
    world.step(1000)
    # Every step rounds at 1e-17 of 1e-15: no more than 1 % in all.
    np.testing.assert_allclose(box.position[0], 1e-12, rtol=1e-2)
    np.testing.assert_allclose(2 * box.orientation[2], 1e-11, rtol=1e-2)
