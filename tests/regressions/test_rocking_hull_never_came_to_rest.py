"""A hull on three vertices rocked for ever: what took a finished rebound's height out of one vertex
lifted another."""

import numpy as np
import pytest

import rb_physics as rb


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_hull_comes_to_rest(seed, restitution):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3))
    points *= 0.1 * rng.uniform(0.6, 1, (40, 1)) / np.linalg.norm(points, axis=1)[:, None]
    world = rb.World(dt=1e-3)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", restitution=restitution
    )
    hull = world.add_body(rb.ConvexHull(points), mass=1.0, position=(0, 0, 0.15))
    world.step(6000)
    for _ in range(20):
        world.step()
        stats = world.stats
        assert (stats.events, stats.impacts, stats.corrections) == (0, 0, 0)
        assert len(world.contacts) >= 3
        # Rounding: a part in 1e13 of g dt.
        np.testing.assert_allclose(hull.linear_velocity, 0, atol=1e-12)
