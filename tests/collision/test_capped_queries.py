"""Iteration caps report themselves."""

import rb_physics as rb


def spinning_beside_a_wall(spin: float) -> rb.World:
    """A cube 1 mm off a wall when its corner points there, turning at about `spin` rad/s."""
    world = rb.World(dt=5e-3, gravity=(0, 0, 0))
    world.add_body(rb.Box((1, 1, 0.1)), type="static", name="wall", position=(0, 0, -0.1))
    world.add_body(
        rb.Box((0.1, 0.1, 0.1)),
        mass=1.0,
        name="cube",
        position=(0, 0, 0.1 * 3**0.5 + 1e-3),
        linear_velocity=(0, 0, -0.01),
        angular_velocity=(spin, 2 * spin, 3 * spin),
    )
    return world


def test_searches_cut_short_are_counted_in_the_stats():
    # 5 ms are 3000 turns: more near misses than the search for a contact time may look at.
    world = spinning_beside_a_wall(1e6)
    world.step()
    assert world.stats.queries_capped > 0


def test_ordinary_steps_count_none():
    world = spinning_beside_a_wall(10.0)
    for _ in range(20):
        world.step()
        assert world.stats.queries_capped == 0
