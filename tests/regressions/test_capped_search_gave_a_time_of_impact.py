"""A search that ended early handed out the time it had come to as the contact time."""

import numpy as np
import pytest

import rb_physics as rb


def two(shape_a, shape_b, apart, **kwargs) -> tuple[rb.Body, rb.Body]:
    world = rb.World(**kwargs)
    a = world.add_body(shape_a, mass=1.0, name="a", position=apart)
    b = world.add_body(shape_b, mass=1.0, name="b")
    return a, b


@pytest.mark.parametrize("t_max", [1.0, 1e3, 1e6])
def test_bodies_that_fall_side_by_side_never_meet(t_max):
    a, b = two(rb.Sphere(0.1), rb.Box((0.1, 0.1, 0.1)), (3, 0, 0))
    assert rb.time_of_impact(a, b, t_max) is None


@pytest.mark.parametrize("offset", [0.0, 1.5, 2.5, 10.0])
def test_balls_in_common_free_fall(offset):
    radius, speed = 0.1, 0.01
    a, b = two(rb.Sphere(radius), rb.Sphere(radius), (20 * radius, offset * radius, 100))
    b.position = (0, 0, 100)
    a.linear_velocity = (-speed, 0, 0)
    found = rb.time_of_impact(a, b, 400.0)
    if offset > 2:
        assert found is None
    else:
        exact = (20 - np.sqrt(4 - offset**2)) * radius / speed
        # They have fallen 2e5 m by then: rounding of that over the speed.
        assert found == pytest.approx(exact, abs=1e-7)


def test_a_search_that_gives_up_says_so():
    a, b = two(rb.Box((0.1,) * 3), rb.Box((0.1,) * 3), (0.5, 0.3, 0), gravity=(0, 0, 0))
    a.angular_velocity, b.angular_velocity = (0, 0, 1e8), (1e8, 0, 3e7)
    with pytest.raises(RuntimeError, match="no contact found up to"):
        rb.time_of_impact(a, b, 1.0)
