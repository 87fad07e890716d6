"""A bullet that an oblique plate turned aside within a step went through whatever thin stood in its
new way: candidates were those of its first course. The step is made again with wider eyes."""

import numpy as np
import pytest

import rb_physics as rb


@pytest.mark.parametrize("kind", ["static", "kinematic", "dynamic"])
@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_a_ricochet_passes_no_wall(stepper, kind):
    for seed in range(30):
        rng = np.random.default_rng(seed)
        world = rb.World(dt=5e-3, gravity=(0, 0, 0), stepper=stepper)
        world.add_body(
            rb.Box((0.001, 0.04, 0.2)),
            type="static",
            name="plate",
            orientation=(0, 0, np.sin(np.pi / 8), np.cos(np.pi / 8)),  # 45 degrees
            restitution=1.0,
            friction=0.0,
        )
        mass = {"mass": 1e4} if kind == "dynamic" else {}
        aside = 0.06 + 0.1 * rng.random()
        walls = [
            world.add_body(
                rb.Box((0.5, 0.0005, 0.5)),
                type=kind,
                name=f"wall_{k}",
                position=(0, sign * aside, 0),
                restitution=1.0,
                **mass,
            )
            for k, sign in enumerate((-1, 1))
        ]
        shapes = [
            rb.Particle(),
            rb.Sphere(0.004),
            rb.Box((0.003, 0.004, 0.002)),
            rb.ConvexHull(0.004 * rng.normal(size=(10, 3))),
        ]
        bullet = world.add_body(
            shapes[rng.integers(4)],
            mass=0.01,
            position=(-0.03 - 0.2 * rng.random(), 0, 0),
            linear_velocity=(100, 0, 0),
            name="bullet",
            restitution=1.0,
            friction=0.0,
        )
        retries = 0
        for _ in range(3):
            world.step()
            retries += world.stats.retries
            y = bullet.com_position[1]
            assert walls[0].com_position[1] < y < walls[1].com_position[1], seed
        assert retries > 0


def test_nothing_is_repeated_where_there_is_nothing_beside():
    world = rb.World(dt=5e-3, gravity=(0, 0, 0))
    world.add_body(rb.Box((0.0005, 1, 1)), type="static", name="wall", restitution=1.0)
    bullet = world.add_body(
        rb.Sphere(0.004),
        mass=0.01,
        position=(-0.3, 0, 0),
        linear_velocity=(100, 30, 0),
        name="bullet",
    )
    world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=1.0, position=(-3, 0, 0), name="far")
    for _ in range(4):
        world.step()
        assert world.stats.retries == 0
    assert bullet.linear_velocity[0] < 0
