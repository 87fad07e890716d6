"""time_of_impact gave the time at which its search ran out of work as the time of a contact."""

import numpy as np
import pytest

import rb_physics as rb


def balls(radius, speed, offset):
    """Two balls in common free fall, one passing the other at `offset` radii."""
    world = rb.World()
    a = world.add_body(
        rb.Sphere(radius),
        mass=1.0,
        name="a",
        position=(20 * radius, offset * radius, 100),
        linear_velocity=(-speed, 0, 0),
    )
    b = world.add_body(rb.Sphere(radius), mass=2.0, name="b", position=(0, 0, 100))
    return a, b


@pytest.mark.parametrize("radius", [1e-3, 1e-2, 0.1])
@pytest.mark.parametrize("speed", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("offset", [0.0, 1.5, 2.5, 10.0])
def test_gravity_that_acts_on_both_does_not_matter(radius, speed, offset):
    t_max = 40 * radius / speed
    found = rb.time_of_impact(*balls(radius, speed, offset), t_max)
    if offset > 2:
        assert found is None
    else:
        exact = radius * (20 - np.sqrt(4 - offset**2)) / speed
        # Positions are rounded at 1e-14 m (100 m up), 1e-12 s at the least speed.
        assert found == pytest.approx(exact, rel=1e-10, abs=1e-11)


@pytest.mark.parametrize("t_max", [1.0, 1e3, 1e6, 1e9, 1e15, 1e100, 1e200])
def test_side_by_side_they_fall_for_ever(t_max):
    world = rb.World()
    ground = world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground")
    ball = world.add_body(rb.Sphere(0.1), mass=1.0, name="ball", position=(0, 0, 1))
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, name="box", position=(3, 0, 1))
    assert rb.time_of_impact(ball, box, t_max) is None
    assert rb.time_of_impact(box, ball, t_max) is None
    exact = np.sqrt(2 * 0.9 / 9.81)
    for body in (ball, box):
        assert rb.time_of_impact(body, ground, t_max) == pytest.approx(exact, rel=1e-12)


def spinning_boxes(spin):
    world = rb.World(gravity=(0, 0, 0))
    shape = rb.Box((0.1, 0.1, 0.1))
    a = world.add_body(
        shape,
        mass=1.0,
        name="a",
        position=(0.5, 0.3, 0),
        angular_velocity=(0, 0, spin),
        linear_velocity=(-1, 0, 0),
    )
    b = world.add_body(shape, mass=1.0, name="b", angular_velocity=(spin, 0, 0.3 * spin))
    return a, b


@pytest.mark.parametrize("spin", [1e6, 1e7])
def test_turns_without_end_are_an_error(spin):
    a, b = spinning_boxes(spin)
    # Their balls of radius 0.1 sqrt 3 meet when the centres are sqrt(0.12 - 0.09) m apart in x.
    apart = 0.5 - np.sqrt(0.12 - 0.09)
    assert rb.time_of_impact(a, b, 0.999 * apart) is None
    with pytest.raises(
        rb.SceneError, match=r"'a' and 'b' do not meet before t = 0\.\d+ s"
    ) as error:
        rb.time_of_impact(a, b, 1.0)
    assert error.value.field == "t_max"
    assert float(str(error.value).split(" t = ")[1].split()[0]) >= 0.999 * apart


def test_flight_beyond_all_digits_is_an_error_or_exact():
    """A box that comes so slowly that its place is lost in rounding before it arrives."""
    world = rb.World(gravity=(0, 0, 0))
    shape = rb.Sphere(1e-4)
    a = world.add_body(
        shape, mass=1.0, name="a", position=(-3e12, 0, 0), linear_velocity=(1e6, 0, 0)
    )
    b = world.add_body(shape, mass=1.0, name="b")
    with pytest.raises(rb.SceneError, match="cannot be told"):
        rb.time_of_impact(a, b, 1e9)
