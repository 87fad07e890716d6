"""Continuous collision at random: bullets of every convex shape, turning and spinning, against walls
of 1 mm of every shape, at 100 m/s and steps of 5 ms. None may be found behind the wall, nor may a
strike give it energy."""

import numpy as np
import pytest

import rb_physics as rb

UPRIGHT = (0, 0, 0, 1)
TURNED = (0, np.sqrt(0.5), 0, np.sqrt(0.5))  # axis z -> x
HALF = 0.0005  # m, half of the wall
KINDS = ("static", "kinematic", "dynamic", "moving")
WALLS = ("box", "hull", "cylinder", "capsules", "spheres", "tiles", "mesh", "half_space")
BULLETS = ("particle", "sphere", "box", "plate", "capsule", "cylinder", "coin", "hull", "compound")


def _prism(corners):
    angles = 2 * np.pi * np.arange(corners) / corners
    face = np.column_stack([np.full(corners, HALF), np.cos(angles), np.sin(angles)])
    return np.vstack([face * [-1, 1, 1], face])


def _wall(name):
    """Shape, orientation, and how far from the middle it is a wall, m."""
    if name == "box":
        return rb.Box((HALF, 1, 1)), UPRIGHT, 1.0
    if name == "hull":
        return rb.ConvexHull(_prism(9)), UPRIGHT, 0.9
    if name == "cylinder":
        return rb.Cylinder(1.0, HALF), TURNED, 0.9
    if name == "capsules":  # side by side, overlapping
        rows = np.arange(-30, 31) * 0.8 * HALF
        return (
            rb.Compound([(rb.Capsule(HALF, 0.5), (0, y, 0), UPRIGHT) for y in rows]),
            UPRIGHT,
            0.01,
        )
    if name == "spheres":
        rows = np.arange(-5, 6) * 0.8 * HALF
        balls = [(rb.Sphere(HALF), (0, y, z), UPRIGHT) for y in rows for z in rows]
        return rb.Compound(balls), UPRIGHT, 0.0015
    if name == "tiles":
        tiles = [(rb.Box((HALF, 0.5, 1)), (0, y, 0), UPRIGHT) for y in (-0.5, 0.5)]
        return rb.Compound(tiles), UPRIGHT, 1.0
    if name == "mesh":
        corners = np.array([[x, y, z] for x in (-HALF, HALF) for y in (-1, 1) for z in (-1, 1)])
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
        return rb.TriangleMesh(corners, triangles), UPRIGHT, 1.0
    return rb.HalfSpace((-1, 0, 0), 0.0), UPRIGHT, 1.0


def _bullet(rng, name, size):
    if name == "hull":
        return rb.ConvexHull(size * rng.normal(size=(13, 3)))
    if name == "compound":
        rod = rb.Box((size, 0.2 * size, 0.3 * size))
        return rb.Compound(
            [(rb.Sphere(0.4 * size), (size, 0, 0), UPRIGHT), (rod, (0, 0, 0), UPRIGHT)]
        )
    return {
        "particle": rb.Particle(),
        "sphere": rb.Sphere(size),
        "box": rb.Box((size, 0.7 * size, 1.1 * size)),
        "plate": rb.Box((size, 0.05 * size, 1.1 * size)),
        "capsule": rb.Capsule(0.4 * size, size),
        "cylinder": rb.Cylinder(0.7 * size, size),
        "coin": rb.Cylinder(size, 0.05 * size),
    }[name]


def shoot(seed, **given):
    """One bullet at one wall, 12 steps. Returns the case, and None or what went wrong."""
    return shoot_and_count(seed, **given)[:2]


def shoot_and_count(seed, **given):
    """The same, and how often the bullet had to wait at the wall."""
    rng = np.random.default_rng(seed)
    case = {
        "wall": str(rng.choice(WALLS)),
        "bullet": str(rng.choice(BULLETS)),
        "kind": str(rng.choice(KINDS)),
        "size": float(rng.choice([0.0007, 0.004, 0.01, 0.03])),
        "spin": float(rng.choice([0, 10, 200, 1500])),
        "stepper": str(rng.choice(["fixed", "fixed", "event"])),
        "law": str(rng.choice(["sequential", "simultaneous", "reflections"])),
        "restitution": float(rng.choice([0, 0.5, 1])),
        "friction": float(rng.choice([0, 0.5])),
        "gravity": float(rng.choice([0, 9.81])),
        "aside": float(rng.choice([0, 30])),  # m/s
        "max_events": int(rng.choice([16, 16, 1])),
    } | given
    shape, orientation, extent = _wall(case["wall"])
    small = case["wall"] in ("capsules", "spheres")
    if small and case["bullet"] == "particle":
        case["bullet"] = "sphere"  # between two balls there is a way through
    if case["wall"] == "mesh":
        case["kind"] = "static"
    if case["wall"] == "half_space" and case["kind"] == "dynamic":
        case["kind"] = "static"
    size = case["size"]
    speed = 20.0 if case["kind"] == "moving" else 100.0
    closing = 120.0 if case["kind"] == "moving" else 100.0
    start = 0.06 + 2 * size + 0.8 * rng.uniform()
    aside = rng.uniform(-1, 1, 2) * case["aside"] * (0 if small else 1)
    aim = rng.uniform(-0.4, 0.4, 2) * extent
    world = rb.World(
        dt=5e-3,
        gravity=(0, 0, 0 if small else -case["gravity"]),
        stepper=case["stepper"],
        impact_law=case["law"],
        max_events=case["max_events"],
    )
    body = {"type": case["kind"]}
    if case["kind"] == "dynamic":
        body["mass"] = 1e4
    if case["kind"] == "moving":
        body = {"type": "kinematic", "linear_velocity": (-100, 0, 0)}
    wall = world.add_body(
        shape, name="wall", orientation=orientation, friction=case["friction"], **body
    )
    turning = {}
    if case["bullet"] != "particle":
        turning["angular_velocity"] = rng.uniform(-1, 1, 3) * case["spin"]
        turning["orientation"] = (lambda q: q / np.linalg.norm(q))(rng.normal(size=4))
    bullet = world.add_body(
        _bullet(rng, case["bullet"], size),
        mass=0.01,
        name="bullet",
        position=(-start, *(aim - aside * start / closing)),
        linear_velocity=(speed, *aside),
        restitution=case["restitution"],
        friction=case["friction"],
        **turning,
    )
    waits = 0
    for step in range(12):
        world.step()
        waits += world.stats.waits
        behind = bullet.com_position[0] - wall.com_position[0]
        if behind > 0.4 * HALF and np.abs(bullet.com_position[1:]).max() < extent:
            return case, f"is {behind:.2g} m behind the wall at step {step}", waits
        if case["kind"] == "static" and world.stats.energy_error > 1e-9:
            return case, f"gained energy: {world.stats.energy_error:.2g}", waits
    return case, None, waits


def test_no_bullet_passes_a_thin_wall():
    for seed in range(250):
        case, failure = shoot(seed, stepper="fixed")
        assert failure is None, (seed, case, failure)


@pytest.mark.soak
@pytest.mark.parametrize("part", range(12))
def test_ten_thousand_bullets_pass_no_thin_wall(part):
    for seed in range(1000 * part, 1000 * (part + 1)):
        case, failure = shoot(seed)
        assert failure is None, (seed, case, failure)


def test_what_has_no_events_left_waits_at_the_wall():
    waits = 0
    for seed in range(1000, 1060):
        case, failure, waited = shoot_and_count(
            seed, stepper="fixed", max_events=1, spin=1500.0, bullet="hull", wall="box"
        )
        assert failure is None, (seed, case, failure)
        waits += waited
    assert waits > 0  # and world.stats says so
