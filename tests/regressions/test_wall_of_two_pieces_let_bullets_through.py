"""What came towards the seam of two level pieces was not looked for on the farther one."""

import numpy as np
import pytest

import rb_physics as rb

LEVEL = (0, 0, 0, 1)
PIECE = rb.Box((0.0005, 0.5, 1))
BULLETS = {
    "particle": rb.Particle(),
    "ball": rb.Sphere(0.002),
    "box": rb.Box((0.004, 0.003, 0.005)),
}


@pytest.mark.parametrize("bullet", BULLETS)
@pytest.mark.parametrize("wall", ["bodies", "compound"])
@pytest.mark.parametrize(("dt", "speed"), [(5e-3, 100.0), (1e-2, 5.0)])
def test_nothing_passes(wall, bullet, dt, speed):
    for seed in range(60):
        rng = np.random.default_rng(seed)
        aim, aside, start = (
            rng.uniform(-0.4, 0.4),
            rng.uniform(-0.3, 0.3, 2),
            rng.uniform(0.06, 0.9),
        )
        world = rb.World(dt=dt, gravity=(0, 0, 0))
        places = [(0, 0.5, 0), (0, -0.5, 0)]
        if wall == "compound":
            parts = rb.Compound([(PIECE, at, LEVEL) for at in places])
            world.add_body(parts, type="static", name="wall")
        else:
            for k, at in enumerate(places):
                world.add_body(PIECE, type="static", name=f"piece{k}", position=at)
        body = world.add_body(
            BULLETS[bullet],
            mass=0.01,
            name="bullet",
            position=(-start, aim - aside[0] * start, -aside[1] * start),
            linear_velocity=(speed, *(speed * aside)),
        )
        for _ in range(int(1.2 / (speed * dt)) + 2):
            world.step()
            assert body.position[0] <= 0, seed


def test_a_ball_bounces_off_tiles_as_off_a_slab():
    def thrown(floor, seed):
        rng = np.random.default_rng(seed)
        world = rb.World(dt=1e-2)
        for k, (shape, at) in enumerate(floor):
            world.add_body(
                shape, type="static", name=f"piece{k}", position=at, friction=0, restitution=0.8
            )
        ball = world.add_body(
            rb.Sphere(0.05),
            mass=1.0,
            name="ball",
            position=(*rng.uniform(-0.9, 0.9, 2), 0.5),
            linear_velocity=(*rng.uniform(-5, 5, 2), -2),
            friction=0.0,
            restitution=0.8,
        )
        world.step(60)
        return ball.position

    places = [(x, y) for x in range(-5, 5) for y in range(-5, 5)]
    tiles = [(rb.Box((0.5, 0.5, 0.1)), (x + 0.5, y + 0.5, -0.1)) for x, y in places]
    slab = [(rb.Box((5, 5, 0.1)), (0, 0, -0.1))]
    for seed in range(60):
        # The contact times differ by rounding.
        assert np.abs(thrown(tiles, seed) - thrown(slab, seed)).max() <= 1e-12, seed
