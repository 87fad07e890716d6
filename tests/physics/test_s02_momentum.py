"""S2: p = m v. F is integrated to p, p divided by m, v integrated to x; the state keeps p."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import rb_physics as rb

component = st.floats(-10, 10, allow_nan=False)
vector = st.tuples(component, component, component)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(force=vector, velocity=vector, mass=st.floats(0.1, 100), dt=st.sampled_from([1e-3, 1e-2]))
def test_constant_force_is_integrated_exactly(force, velocity, mass, dt):
    world = rb.World(gravity=(0, 0, 0), dt=dt)
    body = world.add_body(rb.Sphere(0.1), mass=mass, linear_velocity=velocity)
    body.apply_wrench(force=force)
    n = 200
    world.step(n)
    t = n * dt
    f, v = np.array(force), np.array(velocity)
    # Rounding of n additions of numbers of the size of the result.
    scale = 1e-13 * (1 + np.abs(f).max() * t + mass * np.abs(v).max())
    np.testing.assert_allclose(world.linear_momentum, mass * v + t * f, atol=scale)
    reach = 1e-13 * (1 + np.abs(v).max() * t + np.abs(f).max() / mass * t * t)
    np.testing.assert_allclose(body.com_position, v * t + 0.5 * t * t * f / mass, atol=reach)


def test_an_impulse_changes_momentum_at_once():
    world = rb.World(gravity=(0, 0, 0))
    body = world.add_body(rb.Box((0.5, 0.5, 0.5)), mass=2.0)
    body.apply_impulse((0, 0, 3.0), point=(0.5, 0, 0))
    np.testing.assert_array_equal(world.linear_momentum, [0, 0, 3.0])
    np.testing.assert_array_equal(body.linear_velocity, [0, 0, 1.5])
    # L = r x J = (0.5, 0, 0) x (0, 0, 3) = (0, -1.5, 0): exact products.
    np.testing.assert_array_equal(world.angular_momentum, [0, -1.5, 0])


def test_wrench_duration_gives_force_times_duration_at_any_dt():
    for dt in (1e-3, 7e-3):
        world = rb.World(gravity=(0, 0, 0), dt=dt)
        body = world.add_body(rb.Sphere(0.1), mass=1.0)
        body.apply_wrench(force=(1, 0, 0), duration=0.1)
        world.step(200)
        # 0.1 N s whatever dt is; rounding of the shares.
        np.testing.assert_allclose(world.linear_momentum, [0.1, 0, 0], atol=1e-14)


def test_duration_zero_is_one_step_and_none_is_for_ever():
    world = rb.World(gravity=(0, 0, 0), dt=1e-2)
    once = world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0))
    ever = world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 5, 0))
    once.apply_wrench(force=(1, 0, 0), duration=0)
    ever.apply_wrench(force=(1, 0, 0))
    world.step(10)
    np.testing.assert_allclose(once.linear_velocity[0], 0.01, rtol=1e-15)  # one product
    np.testing.assert_allclose(ever.linear_velocity[0], 0.10, rtol=1e-14)  # ten additions
    ever.clear_wrenches()
    world.step(10)
    np.testing.assert_allclose(ever.linear_velocity[0], 0.10, rtol=1e-14)
