"""Boxes falling on each other in a heap overlapped by millimetres, step after step.

Crossing edges of boxes that lie nearly flat were a single contact point, and what the position
correction turned was put back afterwards.
"""

import numpy as np

import rb_physics as rb


def test_boxes_of_a_heap_do_not_overlap():
    world = rb.World(dt=5e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", name="ground")
    for k, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        wall = rb.HalfSpace(normal=(x, y, 0), offset=-0.5)
        world.add_body(wall, type="static", name=f"wall_{k}")
    random = np.random.default_rng(3)
    for i in range(45):
        q = random.normal(size=4)
        world.add_body(
            rb.Box(random.uniform(0.06, 0.13, 3)),
            mass=1.0,
            position=(0.3 * (i % 3 - 1), 0.3 * (i // 3 % 3 - 1), 0.2 + 0.32 * (i // 9)),
            orientation=q / np.linalg.norm(q),
        )
    deepest = 0.0
    contacts = 0
    for _ in range(120):
        world.step()
        deepest = max(deepest, world.stats.max_penetration)
        contacts = max(contacts, world.stats.contacts)
    assert contacts > 100
    # Corrections converge quadratically; a millionth of the size is what a last pass may leave.
    assert deepest <= 1e-7
