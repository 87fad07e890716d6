"""S14: the conditions on C, seen from outside: f >= 0, nothing approaches, no energy gained; momentum."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import turn

LAWS = ("sequential", "simultaneous", "reflections")


def cluster(seed, law, restitution, stepper="fixed"):
    """Up to 8 balls that all touch neighbours, on a floor, with random velocities; no gravity."""
    rng = np.random.default_rng(seed)
    world = rb.World(gravity=(0, 0, 0), dt=1e-13, impact_law=law, stepper=stepper)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="static",
        friction=0,
        restitution=restitution,
    )
    placed = []
    for _ in range(int(rng.integers(2, 9))):
        for _ in range(200):
            radius = rng.uniform(0.05, 0.2)
            if not placed or rng.random() < 0.3:
                x = np.append(rng.uniform(-0.5, 0.5, 2), radius)
            else:
                other, R = placed[rng.integers(len(placed))]
                d = rng.normal(size=3)
                x = other + d / np.linalg.norm(d) * (R + radius)
            if x[2] >= radius and all(
                np.linalg.norm(x - y) >= radius + R - 1e-13 for y, R in placed
            ):
                placed.append((x, radius))
                break
    balls = [
        world.add_body(
            rb.Sphere(radius),
            mass=10 ** rng.uniform(-2, 2),
            position=x,
            linear_velocity=rng.normal(size=3),
            friction=0.0,
            restitution=restitution,
        )
        for x, radius in placed
    ]
    return world, balls


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_clusters_of_balls(law, restitution):
    for seed in range(60):
        world, balls = cluster(seed, law, restitution)
        energy = world.kinetic_energy
        momentum = world.linear_momentum
        world.step()
        # Nothing gains energy (1e-12 of what there was).
        assert world.kinetic_energy <= energy * (1 + 1e-12), seed
        if restitution == 1.0 and law != "simultaneous":
            assert world.kinetic_energy == pytest.approx(energy, rel=1e-11), seed
        contacts = world.contacts
        repulsive = np.einsum("ij,ij->i", contacts["impulse"], contacts["normal"])
        size = np.abs(contacts["impulse"]).max(initial=0)
        assert (repulsive >= -1e-12 * size).all(), seed
        # No friction: impulses are along the normals, those of the impact; the table has the normals of
        # the step's end, 1e-13 s later: at 100 m/s over 0.1 m they turned by 1e-10.
        across = contacts["impulse"] - repulsive[:, None] * contacts["normal"]
        assert np.abs(across).max(initial=0) <= 1e-10 * size, seed
        # What the floor gave is what the balls got.
        floor = contacts[contacts["body_b"] == 0]["impulse"].sum(axis=0)
        scale = sum(b.mass for b in balls)
        np.testing.assert_allclose(world.linear_momentum - momentum, floor, atol=1e-12 * scale)
        # Where contacts remain, nothing approaches faster than the solver's residual allows.
        for c in contacts:
            a, b = world.bodies[c["body_a"]], world.bodies[c["body_b"]]
            u = c["normal"] @ (a.linear_velocity - b.linear_velocity)
            assert u >= -1e-8, (seed, u)
        assert world.stats.residual <= 1e-8


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("friction", [0.2, 1.0])
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_boxes_thrown_at_each_other_never_gain_energy(law, friction, restitution):
    for seed in range(2):
        rng = np.random.default_rng(seed)
        world = rb.World(gravity=(0, 0, 0), dt=2e-3, impact_law=law)
        for k in range(5):
            q = turn(rng.normal(size=3), rng.uniform(0, 3))
            world.add_body(
                rb.Box(rng.uniform(0.05, 0.15, 3)),
                mass=10 ** rng.uniform(-1, 1),
                position=(0.4 * np.cos(k * 1.26), 0.4 * np.sin(k * 1.26), 0.05 * k),
                orientation=q,
                linear_velocity=(-2 * np.cos(k * 1.26), -2 * np.sin(k * 1.26), 0),
                angular_velocity=rng.normal(size=3) * 5,
                friction=friction,
                restitution=restitution,
            )
        energy = world.kinetic_energy
        p = world.linear_momentum
        for _ in range(60):
            world.step()
            assert world.kinetic_energy <= energy * (1 + 1e-12), seed
            energy = world.kinetic_energy
            assert world.stats.energy_error <= 1e-12
        scale = sum(b.mass for b in world.bodies) * 3
        # Internal impulses cancel: rounding of a few hundred of them.
        np.testing.assert_allclose(world.linear_momentum, p, atol=1e-12 * scale)
