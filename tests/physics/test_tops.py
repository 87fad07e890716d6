"""Tops on a plane: they precess, stay above one point, or turn over."""

import numpy as np
import pytest
from energy import energy

import rb_physics as rb
from benchmarks.stage import rotation, turn

G = 9.81


def top(tilt, spin, friction=2.0, dt=1e-4):
    """A top: a tiny ball as its tip, mass and moments as those of a gyroscope."""
    tip, length, mass = 1e-6, 0.1, 0.5
    moments = (6e-3, 6e-3, 1e-3)
    world = rb.World(dt=dt)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=friction)
    q = turn((0, 1, 0), tilt)
    R = rotation(q)
    body = world.add_body(
        rb.Sphere(tip),
        mass=mass,
        position=(0, 0, tip),
        orientation=q,
        center_of_mass=(0, 0, length),
        inertia=moments,
        angular_velocity=R @ (0, 0, spin),
        friction=friction,
    )
    return world, body, mass, length, moments


def test_top_on_a_rough_plane_precesses():
    """Fast top on its tip: precession at about m g l / (I3 spin), the tip stays, energy stays."""
    spin = 600.0
    world, body, mass, length, moments = top(0.3, spin)
    start = energy(world)
    angles = []
    for _ in range(10000):
        world.step()
        axis = rotation(body.orientation)[:, 2]
        angles.append(np.arctan2(axis[1], axis[0]))
    rate = np.polyfit(np.arange(10000) * world.dt, np.unwrap(angles), 1)[0]
    # Slow precession of a fast top: corrections are of order m g l I1' cos / (I3 spin)² = 1e-2.
    assert rate == pytest.approx(mass * G * length / (moments[2] * spin), rel=0.03)
    # Rolling without slip on the tip: nothing dissipates; dt 1e-4 resolves the nutation.
    assert energy(world) == pytest.approx(start, rel=1e-5)


def moments_spin(body):
    """Angular momentum about the body's third axis."""
    R = rotation(body.orientation)
    return (body.inertia @ (R.T @ body.angular_velocity))[2]


def test_top_without_friction_keeps_its_centre_above_one_point():
    """On ice no horizontal force acts: the centre of mass stays above its point, spin is kept."""
    world, body, *_ = top(0.3, 600.0, friction=0.0)
    start = body.com_position
    L3 = moments_spin(body)
    energy_0 = energy(world)
    world.step(5000)
    np.testing.assert_allclose(body.com_position[:2], start[:2], atol=1e-12)
    assert moments_spin(body) == pytest.approx(L3, rel=1e-8)
    assert energy(world) == pytest.approx(energy_0, rel=1e-5)


def test_tippe_top_turns_over():
    """A ball with its centre of mass below its middle, spun fast, raises it by sliding friction."""
    radius, offset, mass = 0.02, 0.004, 0.02
    world = rb.World(dt=2e-4)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.3)
    moment = 0.4 * mass * radius**2
    body = world.add_body(
        rb.Sphere(radius),
        mass=mass,
        position=(0, 0, radius),
        orientation=turn((1, 0, 0), 0.1),
        center_of_mass=(0, 0, -offset),
        inertia=(moment, moment, moment * 0.95),
        angular_velocity=(0, 0, 180.0),
        friction=0.3,
    )
    first = rotation(body.orientation)[2, 2]
    start = energy(world)
    world.step(15000)
    last = rotation(body.orientation)[2, 2]
    assert first > 0.99
    assert last < 0.3, "its axis has turned over, or is about to"
    assert body.com_position[2] > radius - 0.3 * offset
    assert energy(world) < start  # the rise is paid by spin
