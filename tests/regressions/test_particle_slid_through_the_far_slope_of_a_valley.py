"""A particle that slid down one slope of an open mesh lost its contact at the bottom, by rounding,
and went through the other slope; with friction also where forces changed on the way there."""

import numpy as np
import pytest

import rb_physics as rb


def valley(rng, kind):
    """Its shape, and height over x in [-1, 1]."""
    slope = np.tan(np.radians(rng.uniform(5, 60, 2)))
    if kind == "field":
        slope[:] = slope[0]
    bottom = 0.0 if kind == "field" else rng.uniform(-0.3, 0.3)

    def height(x):
        return slope[0] * (bottom - x) if x < bottom else slope[1] * (x - bottom)

    left, right = height(-1.0), height(1.0)
    if kind == "field":
        return rb.HeightField(np.outer([left, 0, right], [1, 1, 1]), 1.0), height
    points = [(-1, -1, left), (-1, 1, left), (bottom, -1, 0), (bottom, 1, 0)]
    points += [(1, -1, right), (1, 1, right)]
    faces = [(0, 2, 1), (1, 2, 3), (2, 4, 3), (3, 4, 5)]
    if kind == "closed":
        points += [(x, y, -1) for x in (-1, 1) for y in (-1, 1)]
        faces += [(6, 7, 9), (6, 9, 8), (0, 1, 7), (0, 7, 6), (4, 8, 9), (4, 9, 5)]
        faces += [(0, 6, 2), (6, 8, 2), (2, 8, 4), (1, 3, 7), (7, 3, 9), (3, 5, 9)]
    return rb.TriangleMesh(np.array(points, dtype=float), faces), height


@pytest.mark.parametrize("kind", ["open", "closed", "field"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_particle_stays_in_the_valley(kind, friction, restitution):
    for seed in range(60):
        rng = np.random.default_rng(seed)
        shape, height = valley(rng, kind)
        dt = rng.choice([1e-3, 5e-3, 1e-2])
        half_turn = rng.uniform(0, np.pi)
        turned = np.array([0, 0, np.sin(half_turn), np.cos(half_turn)])
        c, s = np.cos(2 * half_turn), np.sin(2 * half_turn)
        axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        corner = [-1.0, -1.0, 0.0] if kind == "field" else [0.0, 0.0, 0.0]
        material = {"friction": friction, "restitution": restitution}
        world = rb.World(dt=dt)
        world.add_body(
            shape,
            type="static",
            name="valley",
            orientation=turned,
            position=axes @ corner,
            **material,
        )
        x, y = rng.uniform(-0.9, 0.9), rng.uniform(-0.5, 0.5)
        start = np.array([x, y, height(x) + 0.2 * rng.random()])
        speed = rng.choice([0, 1, 10]) * rng.normal(size=3) * (0.5, 0.1, 0.5)
        body = world.add_body(
            rb.Particle(),
            mass=1.0,
            name="particle",
            position=axes @ start,
            linear_velocity=axes @ speed,
            **material,
        )
        for _ in range(int(1.0 / dt)):
            world.step()
            x, y, z = axes.T @ body.position
            if max(abs(x), abs(y)) > 1:
                break
            # A millionth of the mesh's size (1.6 m) is what a particle that has just met it may
            # have sunk in.
            assert z - height(x) > -4e-6, seed


def test_a_particle_stays_on_a_crumpled_sheet():
    grid = np.linspace(-1, 1, 6)
    faces = []
    for i in range(5):
        for j in range(5):
            a = 6 * i + j
            faces += [(a, a + 6, a + 7), (a, a + 7, a + 1)]
    for seed in range(120):
        rng = np.random.default_rng(seed)
        heights = rng.choice([0.05, 0.3, 0.8]) * rng.random((6, 6))
        heights += 0.5 * (grid[:, None] ** 2 + grid**2)
        points = np.array(
            [(x, y, heights[i, j]) for i, x in enumerate(grid) for j, y in enumerate(grid)]
        )

        def height(x, y, points=points):
            for a, b, c in points[np.array(faces)]:
                u, v = np.linalg.solve(
                    np.column_stack([b - a, c - a])[:2], np.array([x, y]) - a[:2]
                )
                if u >= -1e-9 and v >= -1e-9 and u + v <= 1 + 1e-9:
                    return a[2] + u * (b - a)[2] + v * (c - a)[2]
            raise AssertionError((x, y))

        material = {"friction": rng.choice([0, 0.3]), "restitution": rng.choice([0, 0.5, 0.9])}
        dt = rng.choice([5e-3, 1e-2])
        world = rb.World(dt=dt)
        world.add_body(rb.TriangleMesh(points, faces), type="static", name="sheet", **material)
        x, y = rng.uniform(-0.7, 0.7, 2)
        body = world.add_body(
            rb.Particle(),
            mass=1.0,
            name="particle",
            position=(x, y, height(x, y) + 0.1),
            linear_velocity=rng.choice([0, 1, 5]) * rng.normal(size=3),
            **material,
        )
        for _ in range(int(0.8 / dt)):
            world.step()
            x, y, z = body.position
            if max(abs(x), abs(y)) > 0.99:
                break
            # As above; steep faces show it longer along z.
            assert z - height(x, y) > -8e-6, seed
