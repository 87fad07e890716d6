"""S10: d, d_dot (with the N_dot term) and d_ddot of contacts of a world, against finite differences."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import multiply, turn


def worlds():
    on_edge = turn((0, 1, 0), np.pi / 4)
    crossed = multiply(turn((0, 0, 1), 1.1), on_edge)
    corner = multiply(turn((1, 0, 0), 0.5), turn((0, 1, 0), 0.6))
    plane, box = rb.HalfSpace(normal=(0, 0, 1), offset=0.0), rb.Box((0.1, 0.5, 0.1))
    return {
        # name: shape A, its orientation, shape B, its orientation, direction in which A lies
        "ball_on_plane": (rb.Sphere(0.1), (0, 0, 0, 1), plane, (0, 0, 0, 1)),
        "corner_on_plane": (box, corner, plane, (0, 0, 0, 1)),
        "edge_on_edge": (box, crossed, box, on_edge),
        "ball_on_ball": (rb.Sphere(0.1), (0, 0, 0, 1), rb.Sphere(0.3), (0, 0, 0, 1)),
        "ball_on_edge": (rb.Sphere(0.1), (0, 0, 0, 1), box, on_edge),
    }


@pytest.mark.parametrize("name", worlds())
def test_rates_match_finite_differences(name):
    shape_a, q_a, shape_b, q_b = worlds()[name]
    fixed = isinstance(shape_b, rb.HalfSpace)

    def placed(t):
        """Both bodies after t seconds with constant velocities; at t = 0 they touch."""
        world = rb.World(gravity=(0, 0, 0))
        b = world.add_body(shape_b, type="static" if fixed else "kinematic", orientation=q_b)
        a = world.add_body(shape_a, mass=1.0, position=(0.01, 0.02, 5.0), orientation=q_a)
        for _ in range(60):
            gap = rb.distance(a, b).distance
            a.position = a.position - (0, 0, gap)
            if abs(gap) < 1e-14:
                break
        a.linear_velocity, a.angular_velocity = (0.3, 0.1, 0.7), (0.5, -0.4, 0.6)
        if not fixed:
            b.linear_velocity, b.angular_velocity = (0.1, -0.2, 0.05), (0.4, 0.3, -0.5)
        if t:
            for body in (a, b) if not fixed else (a,):
                w, com = body.angular_velocity, body.com_position + t * body.linear_velocity
                body.orientation = multiply(turn(w, np.linalg.norm(w) * t), body.orientation)
                body.com_position = com
        return a, b

    h = 1e-3
    d = [rb.distance(*placed(k * h)).distance for k in (-2, -1, 1, 2)]
    d_dot = (d[0] - 8 * d[1] + 8 * d[2] - d[3]) / (12 * h)
    a, b = placed(0)
    found = rb.find_contacts(a, b, margin=1e-9)
    assert len(found) == 1
    normal, point = found["normal"][0], found["point"][0]
    v = a.linear_velocity + np.cross(a.angular_velocity, point - a.com_position)
    v -= b.linear_velocity + np.cross(b.angular_velocity, point - b.com_position)
    # The rate of d is N . V where surfaces touch; fourth-order differences of 1e-3 s leave 1e-11.
    assert normal @ v == pytest.approx(d_dot, abs=1e-9)


def test_rows_of_a_rolling_ball():
    """d = 0, d_dot = 0 and d_ddot = 0 for a ball that rolls on a floor, on a ball d_ddot = 0 as well."""
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    world.add_body(
        rb.Sphere(0.1),
        mass=1.0,
        position=(0, 0, 0.1),
        linear_velocity=(1, 0, 0),
        angular_velocity=(0, 10, 0),
    )
    world.step()
    k = rb.contact_kinematics(world, 0)
    assert k.d == pytest.approx(0, abs=1e-15)
    assert k.d_dot == pytest.approx(0, abs=1e-13)
    # Gravity and the contact force cancel to the solver's residual.
    assert k.d_ddot == pytest.approx(0, abs=1e-11)


def test_d_ddot_has_gravity_and_the_centripetal_terms():
    """A ball that slides over the top of a fixed ball, weightless: d_ddot = v² / (R + r)."""
    R, r, speed = 0.5, 0.1, 2.0
    world = rb.World(gravity=(0, 0, 0), dt=1e-9)
    world.add_body(rb.Sphere(R), type="static", friction=0.0)
    world.add_body(
        rb.Sphere(r), mass=1.0, position=(0, 0, R + r), linear_velocity=(speed, 0, 0), friction=0.0
    )
    world.step()  # 1e-9 s: it is still at the top and touches
    assert len(world.contacts) == 1
    k = rb.contact_kinematics(world, 0)
    # The top was left by 2e-9 m.
    assert k.d_ddot == pytest.approx(speed**2 / (R + r), rel=1e-7)
    assert k.d_dot == pytest.approx(0, abs=1e-7)


def test_unknown_row_is_refused():
    world = rb.World()
    with pytest.raises(
        rb.SceneError, match="contact row 0 does not exist; world.contacts has 0 rows"
    ):
        rb.contact_kinematics(world, 0)
