"""Where a step's time goes is told, and told to nobody who computes."""

import rb_physics as rb


def test_stages_add_up_to_no_more_than_the_step() -> None:
    world = rb.World()
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static")
    for k in range(20):
        world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(k, 0, 0.1))
    world.step(5)
    stats = world.stats
    stages = (stats.detect_time, stats.advance_time, stats.correct_time)
    assert all(stage > 0 for stage in stages[:2])
    # Rounding of sums of differences of a clock.
    assert sum(stages) <= stats.step_time * (1 + 1e-9)
    assert stats.step_time < 1.0
