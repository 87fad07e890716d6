"""Rays against closed forms and against the inside-outside function of every shape."""

import numpy as np
import pytest

from rb_physics import _core

IDENTITY = (0, 0, 0, 1)
CAPSULE = _core.Capsule(0.3, 0.5)
CYLINDER = _core.Cylinder(0.3, 0.5)
BOX = _core.Box((0.3, 0.4, 0.5))
PLACED = _core.Compound(
    [(_core.Sphere(0.3), (1, 0, 0), IDENTITY), (BOX, (-0.5, 0.2, 0), (0, 0, 0.6, 0.8))]
)


def cast(shape, origin, direction, position=(0, 0, 0), orientation=IDENTITY):
    return _core.ray_cast(shape, position, orientation, origin, direction)


@pytest.mark.parametrize(
    ("shape", "origin", "direction", "distance", "normal"),
    [
        (_core.Sphere(0.5), (-3, 0.3, 0), (2, 0, 0), 2.6, (-0.8, 0.6, 0)),
        (BOX, (-3, 0.1, 0.2), (1, 0, 0), 2.7, (-1, 0, 0)),
        (BOX, (0.1, 0.2, 4), (0, 0, -5), 3.5, (0, 0, 1)),
        (CAPSULE, (-3, 0, 0.4), (1, 0, 0), 2.7, (-1, 0, 0)),
        (CAPSULE, (0, 0, 4), (0, 0, -1), 3.2, (0, 0, 1)),
        (CAPSULE, (-3, 0, 0.74), (1, 0, 0), 2.82, (-0.6, 0, 0.8)),
        (CYLINDER, (-3, 0.18, 0.4), (1, 0, 0), 2.76, (-0.8, 0.6, 0)),
        (CYLINDER, (0.1, 0.1, 4), (0, 0, -1), 3.5, (0, 0, 1)),
        (_core.HalfSpace((0, 0, 1), 0.5), (0, 0, 2), (0, 3, -4), 1.875, (0, 0, 1)),
        (PLACED, (1, 0, 5), (0, 0, -1), 4.7, (0, 0, 1)),
    ],
)
def test_closed_forms(shape, origin, direction, distance, normal):
    hit = cast(shape, origin, direction)
    assert hit[0] == pytest.approx(distance, abs=4e-15)  # a few roundings of numbers of order 1
    np.testing.assert_allclose(hit[2], normal, atol=1e-14)
    unit = np.array(direction) / np.linalg.norm(direction)
    np.testing.assert_allclose(hit[1], origin + distance * unit, atol=4e-15)


@pytest.mark.parametrize(
    ("shape", "origin", "direction"),
    [
        (_core.Sphere(0.5), (-3, 0.51, 0), (1, 0, 0)),
        (_core.Sphere(0.5), (-3, 0, 0), (-1, 0, 0)),
        (BOX, (-3, 0.41, 0), (1, 0, 0)),
        (BOX, (3, 0, 0), (1, 0, 0)),
        (CAPSULE, (-3, 0, 0.81), (1, 0, 0)),
        (CYLINDER, (-3, 0, 0.51), (1, 0, 0)),
        (CYLINDER, (0.31, 0, 3), (0, 0, -1)),
        (_core.HalfSpace((0, 0, 1), 0.5), (0, 0, 2), (1, 0, 0)),
        (_core.HalfSpace((0, 0, 1), 0.5), (0, 0, 2), (1, 0, 0.1)),
        (_core.Particle(), (-1, 0, 0), (1, 0, 0)),
    ],
)
def test_misses(shape, origin, direction):
    assert cast(shape, origin, direction) is None


@pytest.mark.parametrize("shape", [_core.Sphere(0.5), BOX, CAPSULE, CYLINDER, _core.HalfSpace()])
def test_a_ray_that_starts_inside_hits_at_once(shape):
    distance, point, normal = cast(shape, (0.1, 0.05, -0.02), (1, 2, 2))
    assert distance == 0
    np.testing.assert_array_equal(point, (0.1, 0.05, -0.02))
    np.testing.assert_allclose(normal, (-1 / 3, -2 / 3, -2 / 3), atol=1e-15)


@pytest.mark.parametrize("shape", [_core.Sphere(0.5), BOX, CAPSULE, CYLINDER, PLACED])
def test_random_rays_against_the_distance_to_a_point(shape):
    """The hit lies on the surface, nothing before it is inside, and a miss stays outside."""
    rng = np.random.default_rng(0)
    position = rng.normal(size=3)
    orientation = rng.normal(size=4)
    orientation /= np.linalg.norm(orientation)

    def inside(point):
        # A ray that starts inside says so; it is an independent path for these shapes.
        return gap(point) < 0

    def gap(point):
        return signed_distance(shape, position, orientation, point)

    hits = 0
    for _ in range(200):
        origin = position + 3 * rng.normal(size=3)
        if inside(origin):
            continue
        target = position + rng.uniform(-1, 1, 3)
        direction = (target - origin) / np.linalg.norm(target - origin)
        hit = cast(shape, origin, direction, position, orientation)
        far = 10.0 if hit is None else hit[0] - 1e-9
        assert not any(inside(origin + t * direction) for t in np.linspace(0, far, 200))
        if hit is not None:
            hits += 1
            assert abs(gap(hit[1])) < 1e-13
            assert hit[2] @ direction < 0
            # The normal is the gradient of the distance (away from edges).
            h = 1e-6
            gradient = [(gap(hit[1] + h * e) - gap(hit[1] - h * e)) / (2 * h) for e in np.eye(3)]
            if abs(np.linalg.norm(gradient) - 1) < 1e-9:
                np.testing.assert_allclose(hit[2], gradient, atol=1e-5)
    assert hits > 30


def signed_distance(shape, position, orientation, point):
    """Written out here, so that the oracle shares nothing with the core."""
    x, y, z, w = orientation
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    p = rotation.T @ (np.asarray(point) - position)
    if isinstance(shape, _core.Compound):
        return min(signed_distance(s, np.array(at), q, p) for s, at, q in shape.parts)
    if isinstance(shape, _core.Sphere):
        return np.linalg.norm(p) - shape.radius
    if isinstance(shape, _core.Capsule):
        axis = np.clip(p[2], -shape.half_length, shape.half_length)
        return np.linalg.norm(p - [0, 0, axis]) - shape.radius
    if isinstance(shape, _core.Cylinder):
        q = np.array([np.hypot(p[0], p[1]) - shape.radius, abs(p[2]) - shape.half_length])
    else:
        q = np.abs(p) - shape.half_extents
    return np.linalg.norm(np.maximum(q, 0)) + min(q.max(), 0)


@pytest.mark.parametrize("direction", [(0, 0, 0), (float("nan"), 0, 1), (float("inf"), 0, 0)])
def test_bad_directions_are_refused(direction):
    with pytest.raises(ValueError, match="direction"):
        cast(BOX, (0, 0, 3), direction)


def test_far_away_origin_loses_little():
    """The nearest point of the line is used, not b^2 - c: at 1e6 m the hit is good to 1e-9 m."""
    hit = cast(_core.Sphere(0.5), (-1e6, 0.3, 0), (1, 0, 0))
    assert hit[0] == pytest.approx(1e6 - 0.4, abs=1e-9)
