"""Whether a jam takes hits and rest in one solve was asked of the states of the island that its
thread had moved before: the bits of a heap depended on spinners far away and on the number of
threads, and a world just restored read memory that was not there.
"""

import numpy as np
import pytest

import rb_physics as rb


def heap(threads: int = 1, spinners: float = 0.0) -> rb.World:
    """36 boxes, capsules and cylinders of some 20 m that fall into a bin, spinners 5 km away."""
    rng = np.random.default_rng(5)
    world = rb.World(dt=1e-2, gravity=(0, 0, -981.0), threads=threads)
    world.add_body(rb.Box((220, 220, 50)), type="static", position=(0, 0, -50))
    for side in (-1, 1):
        x = side * 130
        world.add_body(rb.Box((20, 220, 300)), type="static", position=(x, 0, 300))
        world.add_body(rb.Box((220, 20, 300)), type="static", position=(0, x, 300))
    shapes = (rb.Box((20, 15, 25)), rb.Capsule(15, 20), rb.Cylinder(18, 20))
    for i in range(36):
        layer, place = divmod(i, 4)
        centre = np.array((90 * (place % 2 - 0.5), 90 * (place // 2 - 0.5), 50 + 63 * layer))
        q = rng.normal(size=4)
        world.add_body(
            shapes[i % 3],
            mass=5e7,
            position=centre + rng.normal(size=3) * 2,
            orientation=q / np.linalg.norm(q),
        )
    world.add_body(rb.Box((2900, 900, 50)), type="static", position=(-5000, 0, -50))
    for k in range(12):
        world.add_body(
            rb.Box((30, 30, 30)),
            mass=1e12,
            position=(-7000 + 150 * k, 0, 30),
            angular_velocity=(0, 0, spinners),
            friction=0,
        )
    return world


def bits(world: rb.World) -> bytes:
    poses = np.hstack([world.positions, world.orientations])
    return np.hstack([poses, world.linear_velocities, world.angular_velocities])[:41].tobytes()


def test_threads_that_move_spinners_change_no_bit():
    one, two = heap(1, spinners=50.0), heap(2, spinners=50.0)
    for _ in range(5):
        one.step(50)
        two.step(50)
        assert bits(one) == bits(two)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_world_restored_in_a_jam_goes_on(threads):
    world = heap()
    world.step(160)
    fresh = heap(threads)
    fresh.restore(world.save())
    world.step(80)
    fresh.step(80)
    assert bits(world) == bits(fresh)
