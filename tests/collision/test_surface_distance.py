"""The distance to a mesh or height field changes no faster than the body moves, also at its concave
edges: from outside, and for round bodies that are in no deeper than a fifth of their size."""

import numpy as np
import pytest

from rb_physics import _core as core

UPRIGHT = (0, 0, 0, 1)
SHAPES = {
    "particle": core.Particle(),
    "sphere": core.Sphere(0.1),
    "box": core.Box((0.1, 0.08, 0.06)),
    "capsule": core.Capsule(0.05, 0.1),
    "cylinder": core.Cylinder(0.08, 0.1),
}


def _surface(kind, slope):
    """A valley (slope > 0) or ridge along y."""
    if kind == "height_field":
        heights = np.outer([slope, 0.0, slope], [1.0, 1.0, 1.0])
        return core.HeightField(heights, 1.0), (-1.0, -1.0, 0.0)
    vertices = [(x, y, slope * abs(x)) for x in (-1, 0, 1) for y in (-1, 1)]
    return core.TriangleMesh(vertices, [(0, 2, 3), (0, 3, 1), (2, 4, 5), (2, 5, 3)]), (0, 0, 0)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("slope", [0.5, -0.5])
@pytest.mark.parametrize("kind", ["mesh", "height_field"])
def test_distance_does_not_jump(kind, slope, shape):
    surface, at = _surface(kind, slope)
    step = 1e-3  # m
    # Overlapping, corners count by the face that they are behind.
    deepest = 0.0 if shape in ("box", "cylinder") else -0.02
    compared = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        direction = rng.normal(size=3)
        direction *= step / np.linalg.norm(direction)
        place = np.array([*rng.uniform(-0.3, 0.3, 2), 0.0])
        place[2] = slope * abs(place[0]) + rng.uniform(-0.1, 0.3)
        before = None
        for _ in range(160):
            place = place + direction
            now = core.distance(SHAPES[shape], place, UPRIGHT, surface, at, UPRIGHT)[0]
            if before is not None and min(now, before) > deepest:
                assert abs(now - before) <= step + 1e-12  # rounding
                compared += 1
            before = now
    assert compared > 1000
