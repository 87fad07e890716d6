"""A bullet that spun fast while it slid over its contact had it close again every nanosecond: an event
each time, after which it waited for the rest of the step, in every step."""

from tests.collision.test_thin_walls import shoot_and_count


def test_it_leaves_the_wall():
    for seed in (63303, 60717):
        case, failure, waits = shoot_and_count(seed)
        assert failure is None, case
        assert waits <= 2
