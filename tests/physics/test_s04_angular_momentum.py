"""S4: L = J omega, tau = dL/dt, omega = J^-1 L with J^-1 = R J_b^-1 R^T; the state keeps L."""

import numpy as np

import rb_physics as rb

RNG = np.random.default_rng(4)


def spinning_body(inertia=(1.0, 2.0, 3.0), omega=(0.01, 5.0, 0.01), dt=1e-3, **keywords):
    world = rb.World(gravity=(0, 0, 0), dt=dt, **keywords)
    body = world.add_body(rb.Sphere(0.5), mass=1.0, inertia=inertia, angular_velocity=omega)
    return world, body


def test_angular_velocity_from_momentum_in_world_axes():
    q = RNG.normal(size=4)
    q /= np.linalg.norm(q)
    rotation = rb.math.rotation_matrix(q)
    moments = np.diag([1.0, 2.0, 2.5])
    omega = RNG.normal(size=3)
    world = rb.World(gravity=(0, 0, 0))
    body = world.add_body(
        rb.Sphere(0.5), mass=1.0, inertia=moments, orientation=q, angular_velocity=omega
    )
    # Two rotations and a division: a few ulp.
    np.testing.assert_allclose(
        world.angular_momentum, rotation @ moments @ rotation.T @ omega, atol=1e-14
    )
    np.testing.assert_allclose(body.angular_velocity, omega, atol=1e-14)


def test_torque_is_the_rate_of_angular_momentum():
    world, body = spinning_body()
    before = world.angular_momentum
    body.apply_wrench(torque=(0.3, -0.2, 0.1))
    world.step(1000)
    # L is stepped with the torque alone: rounding of 2000 additions.
    np.testing.assert_allclose(world.angular_momentum - before, [0.3, -0.2, 0.1], atol=2e-12)


def test_free_rotation_keeps_L_to_the_bit_and_energy_to_rounding():
    for dt, steps in ((1e-3, 60000), (1e-2, 6000)):
        world, _ = spinning_body(dt=dt)
        momentum, energy = world.angular_momentum, world.kinetic_energy
        worst = 0.0
        for _ in range(60):
            world.step(steps // 60)
            worst = max(worst, abs(world.kinetic_energy / energy - 1))
        np.testing.assert_array_equal(world.angular_momentum, momentum)
        assert worst <= 1e-13  # what the accuracy table (make verify) asks for


def test_free_rotation_follows_jacobis_closed_form():
    """omega of the asymmetric top in body axes: sn, cn, dn, computed here to high precision."""
    import scipy.special

    moments = np.array([1.0, 2.0, 3.0])
    omega = np.array([0.4, 1.0, 1.5])
    world, body = spinning_body(omega=omega, dt=1e-2)
    l_sq = float(((moments * omega) ** 2).sum())
    twice_energy = float((moments * omega**2).sum())
    j1, j2, j3 = moments
    assert (
        l_sq > twice_energy * j2
    )  # rotation about the axis of j3: cn with w1, sn with w2, dn with w3
    w1 = np.sqrt((twice_energy * j3 - l_sq) / (j1 * (j3 - j1)))
    w2 = np.sqrt((twice_energy * j3 - l_sq) / (j2 * (j3 - j2)))
    w3 = np.sqrt((l_sq - twice_energy * j1) / (j3 * (j3 - j1)))
    rate = np.sqrt((j3 - j2) * (l_sq - twice_energy * j1) / (j1 * j2 * j3))
    m = (j2 - j1) * (twice_energy * j3 - l_sq) / ((j3 - j2) * (l_sq - twice_energy * j1))
    # Euler's equations: w1' = (j2 - j3)/j1 w2 w3 < 0 for w2, w3 > 0, so the phase grows with cn falling.
    phase = scipy.special.ellipkinc(np.arctan2(omega[1] / w2, omega[0] / w1), m)
    steps = 500
    world.step(steps)
    sn, cn, dn, _ = scipy.special.ellipj(phase + rate * steps * 1e-2, m)
    rotation = rb.math.rotation_matrix(body.orientation)
    # 1e-10: what double leaves after 500 steps and scipy's own elliptic functions (1e-11).
    np.testing.assert_allclose(
        rotation.T @ body.angular_velocity, [w1 * cn, w2 * sn, w3 * dn], atol=1e-10
    )
