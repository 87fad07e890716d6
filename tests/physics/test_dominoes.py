"""A row of dominoes falls at a steady speed."""

import numpy as np
import pytest
from energy import energy

import rb_physics as rb
from benchmarks.stage import rotation

G = 9.81


@pytest.mark.soak
@pytest.mark.parametrize(("spacing", "count"), [(0.05, 12), (0.08, 20)])
def test_domino_row(spacing, count):
    """A push runs down the row at a steady speed, and every domino falls on the next."""
    half = np.array([0.004, 0.02, 0.05])
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.6)
    dominoes = [
        world.add_body(rb.Box(half), mass=0.02, position=(spacing * k, 0, half[2]), friction=0.3)
        for k in range(count)
    ]
    dominoes[0].angular_velocity = (0, 3.0, 0)
    dominoes[0].linear_velocity = (0.15, 0, 0)
    fallen = {}
    start = energy(world)
    for n in range(2500):
        world.step()
        for k, d in enumerate(dominoes):
            if k not in fallen and rotation(d.orientation)[2, 2] < np.cos(0.2):
                fallen[k] = n
        if len(fallen) == count:
            break
    assert list(fallen) == list(range(count)), "one after the other"
    speeds = spacing / (np.diff([fallen[k] for k in range(count // 3, count)]) * world.dt)
    # The front of a domino row settles to a speed of the order of sqrt(g h); steady within a fifth.
    assert speeds.std() < 0.2 * speeds.mean()
    assert 0.3 < speeds.mean() / np.sqrt(G * 2 * half[2]) < 3
    assert energy(world) < start + 1e-9
    assert world.stats.max_penetration < 1e-6
