"""A particle exactly on the seam of two pieces of a floor: it lies and slides as on one piece."""

import numpy as np
import pytest

import rb_physics as rb

UPRIGHT = (0, 0, 0, 1)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
TILE = {"hull": rb.ConvexHull(0.5 * CUBE), "box": rb.Box((0.5, 0.5, 0.5))}
WALKS = {"along": (0.0, 1.0), "across": (1.0, 0.0), "oblique": (0.6, 0.8), "at rest": (0.0, 0.0)}


def _slide(tiles, start, velocity, drop):
    world = rb.World(dt=2e-3)
    for k, (shape, place) in enumerate(tiles):
        world.add_body(shape, type="static", name=f"tile_{k}", position=place, friction=0.3)
    particle = world.add_body(
        rb.Particle(),
        mass=0.1,
        name="particle",
        position=(*start, drop),
        linear_velocity=(*velocity, 0),
        friction=0.3,
    )
    world.step(100)
    return particle


@pytest.mark.parametrize("drop", [0.0, 0.01])
@pytest.mark.parametrize("walk", WALKS)
@pytest.mark.parametrize("tile", TILE)
def test_a_seam_of_tiles_is_not_there(tile, walk, drop):
    grid = [(TILE[tile], (x, y, -0.5)) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    whole = [(rb.Box((1, 1, 0.5)), (0, 0, -0.5))]
    # On the seam of two tiles, and on the corner of all four.
    for start in ((0.0, -0.3), (-0.2, 0.0), (0.0, 0.0)):
        found, expected = (_slide(t, start, WALKS[walk], drop) for t in (grid, whole))
        np.testing.assert_allclose(found.position, expected.position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(
            found.linear_velocity, expected.linear_velocity, rtol=0, atol=1e-9
        )
        assert found.position[2] == pytest.approx(0.0, abs=1e-9)  # the touch distance
