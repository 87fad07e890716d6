"""A box that fell over its edge parted from the floor in every step by what turning makes of a gap
(1e-9 m), and fell shut in an event of its own: up to seven solves a step where one does.
"""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import turn


@pytest.mark.parametrize("dt", [1e-3, 5e-3])
def test_a_box_falls_about_its_edge_without_events(dt):
    world = rb.World(dt=dt)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", name="floor")
    tilt = 0.6  # rad, more than atan(0.1 / 0.3): it falls over
    edge = np.array([0.1, 0.0, -0.3])  # of the box, about which it turns
    sine, cosine = np.sin(tilt), np.cos(tilt)
    corner = np.array([cosine * edge[0] + sine * edge[2], 0.0, cosine * edge[2] - sine * edge[0]])
    world.add_body(
        rb.Box((0.1, 0.1, 0.3)),
        mass=2.0,
        position=-corner,
        orientation=turn((0, 1, 0), tilt),
        friction=0.9,
    )
    for _ in range(round(0.25 / dt)):
        world.step()
        assert world.stats.events == 0
        held = [c for c in world.contacts if c["force"][2] > 0.0]
        assert len(held) == 2  # the corners of the edge
        # The touch distance is 1e-9 of the size: what a body may be apart and still touch.
        assert max(abs(c["separation"]) for c in held) <= 1e-9
