"""Free bodies that tumble."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import multiply, rotation, turn


def test_dzhanibekov():
    """Spun about the middle axis a body flips over and over, with the period of the elliptic integral."""
    from scipy.special import ellipkm1

    moments, spin = np.array([1.0, 2.0, 3.0]), np.array([0.01, 5.0, 0.0])
    world = rb.World(gravity=(0, 0, 0), dt=1e-3)
    body = world.add_body(rb.Sphere(0.3), mass=1.0, inertia=moments, angular_velocity=spin)
    flips, before = [], 1.0
    for n in range(40000):
        world.step()
        w2 = (rotation(body.orientation).T @ body.angular_velocity)[1]
        if w2 * before < 0:
            flips.append(n + before / (before - w2))  # linear between two steps
        before = w2
    # Landau & Lifshitz section 37, for L² < 2 E I_2 axes 1 and 3 change roles.
    I1, I2, I3 = moments
    twice_energy, L2 = (moments * spin**2).sum(), ((moments * spin) ** 2).sum()
    if twice_energy * I2 > L2:
        I1, I3 = I3, I1
    m1 = (I3 - I1) * (L2 - twice_energy * I2) / ((I3 - I2) * (L2 - twice_energy * I1))
    rate = np.sqrt((I3 - I2) * (L2 - twice_energy * I1) / (I1 * I2 * I3))
    half_period = 2 * ellipkm1(m1) / abs(rate)
    periods = np.diff(flips) * world.dt
    assert len(flips) >= 4
    # Zero crossings interpolated within 1 ms: 1e-6 s; 1 - m1 = 1e-5 is known to 1e-11.
    np.testing.assert_allclose(periods, half_period, atol=2e-6)


def test_quaternions_stay_normal():
    world = rb.World(dt=1e-3)
    body = world.add_body(rb.Box((0.1, 0.2, 0.3)), mass=1.0, angular_velocity=(10, 20, -30))
    body.orientation = multiply(turn((1, 0, 0), 0.3), turn((0, 1, 0), 0.3))
    world.step(5000)
    assert np.linalg.norm(body.orientation) == pytest.approx(1, abs=1e-15)
