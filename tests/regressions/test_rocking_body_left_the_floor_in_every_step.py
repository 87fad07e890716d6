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
        assert world.stats.impacts == 0
        assert world.stats.corrections == 0  # no second look for contacts
        held = [c for c in world.contacts if c["force"][2] > 0.0]
        assert len(held) == 2  # the corners of the edge
        # The touch distance is 1e-9 of the size: what a body may be apart and still touch.
        assert max(abs(c["separation"]) for c in held) <= 1e-9


def test_a_column_sways_on_a_belt_as_one():
    """Four boxes set down on a belt tip back about an edge: no box leaves the one below."""
    world = rb.World(dt=5e-3)
    belt = world.add_body(
        rb.Box((2.0, 0.4, 0.05)), type="kinematic", name="belt", position=(0, 0, -0.05)
    )
    belt.linear_velocity = (0.5, 0.0, 0.0)
    for k in range(4):
        world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 0.1 + 0.2 * k))
    world.step(30)  # the slide at the beginning is over
    for _ in range(40):
        world.step()
        assert abs(world["belt"].position[0] - world.time * 0.5) < 1e-12  # rounding of a sum
        assert world.stats.events + world.stats.corrections == 0
        turns = world.angular_velocities[1:, 1]
        assert abs(turns[0]) > 1e-3  # rad/s: it does sway
        np.testing.assert_allclose(turns, turns[0], rtol=1e-6)  # the gaps' third order, of one turn
        assert max(abs(c["separation"]) for c in world.contacts if c["force"][2] > 0.0) <= 1e-9
