"""S3: Skew(u) r = u x r, dR/dt = Skew(omega) R, Gram-Schmidt against drift."""

import numpy as np
import pytest

import rb_physics as rb

RNG = np.random.default_rng(3)


def random_rotation():
    q = RNG.normal(size=4)
    return rb.math.rotation_matrix(q / np.linalg.norm(q))


def test_skew_is_the_cross_product():
    for _ in range(20):
        u, r = RNG.normal(size=(2, 3))
        np.testing.assert_allclose(rb.math.skew(u) @ r, np.cross(u, r), atol=1e-15)  # same products
    # The notes' example.
    expected = [[0, 4, -3], [-4, 0, -1], [3, 1, 0]]
    np.testing.assert_array_equal(rb.math.skew((1, -3, -4)), expected)


def test_rotation_derivative_against_finite_differences():
    rotation, omega = random_rotation(), RNG.normal(size=3)
    h = 1e-6
    turn = rb.math.rotation_matrix(rb.math.quaternion_from_rotation_vector(h * omega))
    back = rb.math.rotation_matrix(rb.math.quaternion_from_rotation_vector(-h * omega))
    difference = (turn @ rotation - back @ rotation) / (2 * h)
    # Central difference: h² |omega|³ / 6 plus rounding / h.
    np.testing.assert_allclose(rb.math.rotation_derivative(rotation, omega), difference, atol=1e-9)


def test_gram_schmidt_removes_drift_and_keeps_the_first_direction():
    for _ in range(20):
        drifted = random_rotation() + 1e-3 * RNG.normal(size=(3, 3))
        clean = rb.math.gram_schmidt(drifted)
        np.testing.assert_allclose(clean.T @ clean, np.eye(3), atol=1e-15 * 4)  # rounding
        assert np.linalg.det(clean) > 0
        first = drifted[:, 0] / np.linalg.norm(drifted[:, 0])
        np.testing.assert_allclose(clean[:, 0], first, atol=1e-15)


def test_gram_schmidt_refuses_parallel_columns():
    with pytest.raises(ValueError, match="parallel"):
        rb.math.gram_schmidt(np.ones((3, 3)))


def test_matrix_integration_with_gram_schmidt_follows_the_quaternion():
    omega, h, n = np.array([0.3, -1.2, 0.7]), 1e-3, 1000
    rotation = np.eye(3)
    for _ in range(n):
        middle = rotation + 0.5 * h * rb.math.rotation_derivative(rotation, omega)
        rotation = rb.math.gram_schmidt(rotation + h * rb.math.rotation_derivative(middle, omega))
    exact = rb.math.rotation_matrix(rb.math.quaternion_from_rotation_vector(omega * h * n))
    # Midpoint rule: (|omega| h)² |omega| t / 6 = 5e-7.
    np.testing.assert_allclose(rotation, exact, atol=1e-6)


def test_sine_and_cosine_agree_with_the_library():
    x = RNG.uniform(-1000, 1000, size=2000)
    ours = np.array([(rb.math.sin(v), rb.math.cos(v)) for v in x])
    # Both are within 1 ulp of the true value.
    np.testing.assert_allclose(ours, np.stack([np.sin(x), np.cos(x)], axis=1), atol=2.3e-16)
