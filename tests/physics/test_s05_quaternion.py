"""S5: dq/dt = omega q / 2, q normalised; the quaternion is the stored orientation, x y z w."""

import numpy as np
import pytest

import rb_physics as rb

RNG = np.random.default_rng(5)


def unit():
    q = RNG.normal(size=4)
    return q / np.linalg.norm(q)


def test_derivative_against_finite_differences():
    q, omega, h = unit(), RNG.normal(size=3), 1e-6
    ahead = rb.math.quaternion_multiply(rb.math.quaternion_from_rotation_vector(h * omega), q)
    behind = rb.math.quaternion_multiply(rb.math.quaternion_from_rotation_vector(-h * omega), q)
    # Central difference: h² plus rounding / h.
    np.testing.assert_allclose(
        rb.math.quaternion_derivative(q, omega), (ahead - behind) / (2 * h), atol=1e-9
    )


def test_derivative_agrees_with_the_matrix_form():
    q, omega = unit(), RNG.normal(size=3)
    h = 1e-6
    moved = q + h * rb.math.quaternion_derivative(q, omega)
    by_quaternion = rb.math.rotation_matrix(rb.math.normalize(moved))
    by_matrix = rb.math.rotation_matrix(q) + h * rb.math.rotation_derivative(
        rb.math.rotation_matrix(q), omega
    )
    np.testing.assert_allclose(by_quaternion, by_matrix, atol=1e-11)  # h² |omega|²


def test_round_trips():
    for _ in range(50):
        q = unit()
        q *= np.sign(q[3])
        # Conversions are a handful of products each.
        np.testing.assert_allclose(rb.math.quaternion(rb.math.rotation_matrix(q)), q, atol=2e-15)
        v = rb.math.rotation_vector(q)
        np.testing.assert_allclose(rb.math.quaternion_from_rotation_vector(v), q, atol=2e-15)


def test_orientation_stays_normalised():
    world = rb.World(gravity=(0, 0, 0), dt=1e-2)
    body = world.add_body(rb.Box((0.1, 0.2, 0.3)), mass=1.0, angular_velocity=(3, 40, -7))
    world.step(2000)
    assert abs(np.linalg.norm(body.orientation) - 1.0) <= 4e-16  # one normalisation


def test_a_sphere_turns_in_closed_form():
    omega = np.array([1.0, -2.0, 0.5])
    world = rb.World(gravity=(0, 0, 0), dt=1e-2)
    body = world.add_body(rb.Sphere(0.3), mass=1.0, angular_velocity=omega)
    world.step(300)
    expected = rb.math.quaternion_from_rotation_vector(3.0 * omega)
    sign = np.sign(expected @ body.orientation)
    np.testing.assert_allclose(body.orientation, sign * expected, atol=1e-14)  # 300 products


@pytest.mark.parametrize("q", [(0, 0, 0, 0), (0, 0, 0, 1.002), (np.nan, 0, 0, 1)])
def test_what_is_not_a_unit_quaternion_is_refused(q):
    with pytest.raises(rb.SceneError, match="orientation"):
        rb.World().add_body(rb.Sphere(1.0), mass=1.0, orientation=q)


def test_a_nearly_unit_quaternion_is_normalised():
    body = rb.World().add_body(rb.Sphere(1.0), mass=1.0, orientation=(0, 0, 0, 1.0005))
    np.testing.assert_array_equal(body.orientation, [0, 0, 0, 1])
