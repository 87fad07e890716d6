"""Known paradoxes of rigid impact with friction: no energy is gained, nothing hangs, cones hold.

What the package does there: an impact's answer is the one its law's problem has; where Newton's
restitution with Coulomb friction would gain energy, the rebound is cut back until it does not; where
Painlevé's rod has no bounded force, the impulse of the step stops the approach.
"""

import time

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import rotation, turn

LAWS = ("sequential", "simultaneous", "reflections")
G = 9.81


def rod(
    angle,
    friction,
    restitution,
    velocity,
    spin,
    law="simultaneous",
    stepper="fixed",
    dt=1e-3,
    gravity=(0, 0, -G),
):
    """A thin rod in the x-z plane, ``angle`` from the floor, its lower end just above the floor."""
    world = rb.World(gravity=gravity, dt=dt, impact_law=law, stepper=stepper)
    material = {"friction": friction, "restitution": restitution}
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", **material)
    half = np.array([0.5, 0.01, 0.01])
    q = turn((0, 1, 0), angle)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    lowest = (corners @ rotation(q).T)[:, 2].min()
    body = world.add_body(
        rb.Box(half),
        mass=1.0,
        position=(0, 0, -lowest + 1e-12),
        orientation=q,
        linear_velocity=velocity,
        angular_velocity=(0, spin, 0),
        **material,
    )
    return world, body


def check_impact(world, energy, friction):
    assert world.kinetic_energy <= energy * (1 + 1e-12)
    contacts = world.contacts
    n = np.einsum("ij,ij->i", contacts["impulse"], contacts["normal"])
    t = np.linalg.norm(contacts["impulse"] - n[:, None] * contacts["normal"], axis=1)
    top = n.max(initial=0)
    assert (n >= -1e-12 * top).all()
    assert (t <= friction * n + 1e-9 * top).all()
    assert np.isfinite(world.linear_velocities).all()


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.8, 1.0])
def test_kanes_paradox(law, stepper, restitution):
    """Newton's restitution with a slip that stops or turns back: Kane's rod would speed up."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        friction = rng.uniform(0.1, 2.0)
        world, _ = rod(
            rng.uniform(0.1, 1.5),
            friction,
            restitution,
            (rng.uniform(-3, 3), 0, rng.uniform(-3, -0.5)),
            rng.uniform(-5, 5),
            law,
            stepper,
            dt=1e-9,
            gravity=(0, 0, 0),
        )
        energy = world.kinetic_energy
        world.step(3)
        check_impact(world, energy, friction)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("friction", [0.5, 1.4, 2.0, 5.0])
@pytest.mark.parametrize("angle", [0.4, 0.8, 1.1, 1.4])
@pytest.mark.parametrize("direction", [1, -1])
def test_painleves_rod(stepper, friction, angle, direction):
    """A rod that slides fast on one end, the way that wedges it in: it jams and topples, and gains nothing."""
    world, body = rod(angle, friction, 0.0, (direction * 3.0, 0, 0), 0.0, stepper=stepper)
    energy = world.kinetic_energy + world.potential_energy
    begin = time.perf_counter()
    for _ in range(1000):
        world.step()
        after = world.kinetic_energy + world.potential_energy
        # Overlaps left by curved paths are lifted out: at most 1e-8 of m g l.
        assert after <= energy + 1e-8 * G
        energy = after
        assert world.stats.max_penetration < 1e-6
    assert time.perf_counter() - begin < 60
    assert np.isfinite(body.position).all()
    assert body.position[2] > 0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.5, 1.0])
def test_three_balls_with_friction(law, restitution):
    """Spinning balls that touch in a row or a triangle: friction of one contact feeds the other."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world = rb.World(gravity=(0, 0, 0), dt=1e-9, impact_law=law)
        r = 0.1
        places = [(0, 0, 0), (2 * r, 0, 0), (4 * r, 0, 0) if seed % 2 else (r, np.sqrt(3) * r, 0)]
        friction = rng.uniform(0, 1.5)
        for x in places:
            world.add_body(
                rb.Sphere(r),
                mass=10 ** rng.uniform(-1, 1),
                position=x,
                friction=friction,
                restitution=restitution,
                linear_velocity=rng.normal(size=3),
                angular_velocity=rng.normal(size=3) * 30,
            )
        energy, p, L = world.kinetic_energy, world.linear_momentum, world.angular_momentum
        world.step(2)
        check_impact(world, energy, friction)
        # Equal and opposite impulses at common points.
        scale = sum(b.mass for b in world.bodies) * 3
        np.testing.assert_allclose(world.linear_momentum, p, atol=1e-12 * scale)
        np.testing.assert_allclose(world.angular_momentum, L, atol=1e-12 * scale)


def test_jam_between_walls_does_not_hang():
    """A box wedged between two rough walls that close in: bounded work, finite numbers."""
    world = rb.World(dt=1e-3)
    walls = []
    for side in (-1, 1):
        walls.append(
            world.add_body(
                rb.Box((0.1, 1, 1)), type="kinematic", position=(side * 0.21, 0, 0), friction=1.0
            )
        )
        walls[-1].linear_velocity = (-side * 0.001, 0, 0)
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, friction=1.0)
    begin = time.perf_counter()
    world.step(50)
    for _ in range(100):
        world.step()
        assert np.isfinite(box.position).all()
        assert np.isfinite(box.contact_wrench).all()
    assert time.perf_counter() - begin < 60


@pytest.mark.parametrize("mass", [1e-4, 1.0, 1e4])
def test_dropped_between_two_fixed_boxes(mass):
    """A ball falls into a gap narrower than itself and stays on the two edges."""
    world = rb.World(dt=1e-3)
    for side in (-1, 1):
        world.add_body(rb.Box((0.1, 0.1, 0.1)), type="static", position=(side * 0.15, 0, -0.1))
    ball = world.add_body(rb.Sphere(0.1), mass=mass, position=(0.0, 0, 0.2), restitution=0.0)
    world.step(3000)
    np.testing.assert_allclose(ball.linear_velocity, 0, atol=1e-6)
    assert ball.position[2] == pytest.approx(np.sqrt(0.1**2 - 0.05**2), abs=1e-7)
    np.testing.assert_allclose(ball.contact_wrench[0] / mass, (0, 0, G), atol=1e-6)
