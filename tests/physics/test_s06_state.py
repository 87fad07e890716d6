"""S6: S = [x, q, p, L], dS/dt = [p/m, omega q / 2, F, tau], by the notes' RK4 and by exact free motion."""

import numpy as np

import rb_physics as rb


def asymmetric(free_motion, dt, omega=(0.01, 5.0, 0.01)):
    world = rb.World(gravity=(0, 0, -9.81), dt=dt, free_motion=free_motion)
    body = world.add_body(
        rb.Box((0.1, 0.2, 0.3)), mass=1.0, inertia=(1, 2, 3), angular_velocity=omega
    )
    return world, body


def angle_between(a, b):
    return 4 * np.arcsin(0.5 * min(np.linalg.norm(a - b), np.linalg.norm(a + b)))


def test_rk4_converges_with_fourth_order_to_the_exact_motion():
    exact_world, exact = asymmetric("exact", 1e-2, omega=(1.0, 2.0, 0.5))
    exact_world.step(200)
    errors = []
    for dt in (2e-2, 1e-2, 5e-3):
        world, body = asymmetric("rk4", dt, omega=(1.0, 2.0, 0.5))
        world.step(round(2.0 / dt))
        errors.append(angle_between(body.orientation, exact.orientation))
    # Halving dt divides the error by 16; between 12 and 20 the asymptotic regime is plain.
    assert 12 < errors[0] / errors[1] < 20
    assert 12 < errors[1] / errors[2] < 20


def test_both_dt_give_the_same_attitude_after_a_minute():
    attitudes = []
    for dt, steps in ((1e-3, 60000), (1e-2, 6000), (5e-4, 120000)):
        world, body = asymmetric("exact", dt)
        world.step(steps)
        attitudes.append(body.orientation)
    # a quaternion stored in double leaves about 1e-10; 1e-9 is asked for.
    assert angle_between(attitudes[0], attitudes[1]) <= 1e-9
    assert angle_between(attitudes[0], attitudes[2]) <= 1e-9


def test_position_is_that_of_the_body_frame_and_com_moves_on_the_parabola():
    world = rb.World(dt=1e-3)
    body = world.add_body(
        rb.Box((0.1, 0.1, 0.1)),
        mass=2.0,
        center_of_mass=(0.05, 0, 0),
        position=(1, 2, 3),
        angular_velocity=(0, 0, 4.0),
        linear_velocity=(1, 0, 0),
    )
    np.testing.assert_allclose(body.com_position, [1.05, 2, 3], atol=1e-15)
    world.step(500)
    t = 0.5
    # 500 exact steps: rounding.
    np.testing.assert_allclose(body.com_position, [1.05 + t, 2, 3 - 0.5 * 9.81 * t * t], atol=1e-13)
    arm = body.com_position - body.position
    np.testing.assert_allclose(np.linalg.norm(arm), 0.05, atol=1e-15)


def test_held_wrench_in_the_body_frame_turns_with_the_body():
    """A thruster on a spinning body: in `body` the force averages out, in `world` it adds up."""
    results = {}
    for frame in ("world", "body"):
        world = rb.World(gravity=(0, 0, 0), dt=1e-4)
        body = world.add_body(rb.Sphere(0.1), mass=1.0, angular_velocity=(0, 0, 2 * np.pi))
        body.apply_wrench(force=(1, 0, 0), frame=frame)
        world.step(10000)  # one turn
        results[frame] = body.linear_velocity
    np.testing.assert_allclose(
        results["world"], [1, 0, 0], atol=1e-12
    )  # rounding of 10000 additions
    # The sum of a full turn of equally spaced unit vectors is zero, to rounding.
    np.testing.assert_allclose(results["body"], [0, 0, 0], atol=1e-12)
