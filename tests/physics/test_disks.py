"""Euler's disk: it keeps its energy when it rolls, and sinks and speeds up with rolling friction."""

import numpy as np
import pytest
from energy import energy

import rb_physics as rb
from benchmarks.stage import rotation, turn

G = 9.81


def disk(tilt, rolling_friction=0.0, dt=2e-4):
    """Euler's disk: a thin cylinder on its edge, at the steady precession of that tilt."""
    radius, half = 0.04, 1e-3
    mass = 0.4
    world = rb.World(dt=dt)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="static",
        friction=3.0,
        rolling_friction=rolling_friction,
    )
    q = turn((0, 1, 0), tilt)
    # Steady motion with the centre at rest: Omega² = 4 g / (r sin tilt) for a thin disk.
    axis = rotation(q)[:, 2]
    omega = np.sqrt(4 * G / (radius * np.sin(tilt)))
    # The whole spin is along the diameter through the contact: -Omega sin(tilt) of it.
    diameter = rotation(q)[:, 0]
    body = world.add_body(
        rb.Cylinder(radius, half),
        mass=mass,
        position=(0, 0, radius * np.sin(tilt) + half * np.cos(tilt)),
        orientation=q,
        angular_velocity=-omega * np.sin(tilt) * diameter,
        friction=3.0,
        rolling_friction=rolling_friction,
    )
    assert axis[2] > 0
    return world, body, omega


def precession(world, body, steps):
    angles = []
    for _ in range(steps):
        world.step()
        axis = rotation(body.orientation)[:, 2]
        angles.append(np.arctan2(axis[1], axis[0]))
    return np.polyfit(np.arange(steps) * world.dt, np.unwrap(angles), 1)[0]


@pytest.mark.parametrize("dt", [2e-4, 1e-3, 2e-3])
@pytest.mark.parametrize("tilt", [0.2, 0.4, 0.8])
def test_eulers_disk_without_rolling_friction_keeps_its_energy(tilt, dt):
    world, _body, _ = disk(tilt, dt=dt)
    world.step(2)  # the start ignores its thickness: the slip that leaves ends at once
    start = energy(world)
    for _ in range(round(1.0 / dt)):
        world.step()
        # Coulomb rolling without slip dissipates nothing.
        assert energy(world) == pytest.approx(start, rel=1e-6)


def test_eulers_disk_with_rolling_friction_sinks_and_speeds_up():
    world, body, _omega = disk(0.4, rolling_friction=2e-3)
    start = energy(world)
    first = abs(precession(world, body, 500))
    energies = [energy(world)]
    for _ in range(8):
        world.step(500)
        energies.append(energy(world))
    assert (np.diff(energies) < 0).all() and energies[0] < start
    assert abs(precession(world, body, 500)) > 1.05 * first
