"""A rack of balls breaks as symmetrically as it stands."""

import numpy as np
import pytest

from benchmarks.stage import Stage, turn


@pytest.mark.parametrize("law", ["simultaneous", "reflections"])
@pytest.mark.parametrize("stage", [Stage(), Stage(attitude=tuple(turn((1, 2, 3), 0.7)))])
@pytest.mark.parametrize("rows", [2, 3, 5])
def test_billiard_break_is_symmetric(law, stage, rows):
    """The cue ball hits the rack head-on: left and right mirror each other to 1e-12."""
    r = 0.0286
    world = stage.world(1e-3, gravity=(0, 0, 0), impact_law=law)
    rack = []
    for k in range(rows):
        for j in range(k + 1):
            x = (k * np.sqrt(3) * r, (2 * j - k) * r, 0)
            rack.append(stage.add(world, stage.sphere(r), 0.17, x, restitution=1.0, friction=0.0))
    stage.add(
        world,
        stage.sphere(r),
        0.17,
        (-2 * r - 2.5e-3, 0, 0),
        velocity=(1, 0, 0),
        restitution=1.0,
        friction=0.0,
    )
    for _ in range(10):
        world.step()
    n = 0
    for k in range(rows):
        row = rack[n : n + k + 1]
        n += k + 1
        for left, right in zip(row, row[::-1], strict=True):
            v, w = stage.velocity(left), stage.velocity(right) * (1, -1, 1)
            np.testing.assert_allclose(v, w, atol=1e-12)
    assert world.kinetic_energy <= 0.5 * 0.17 * stage.mass * stage.size * (1 + 1e-12)
