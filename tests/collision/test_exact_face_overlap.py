"""Face on face: the manifold is the overlap polygon of the two faces, clipped here in exact arithmetic.

Prisms and boxes with corners on a grid of 2^-10 m stand on each other; fractions clip their faces
without rounding.
"""

from fractions import Fraction

import numpy as np
import pytest

from rb_physics import _core as core

IDENTITY = (0.0, 0.0, 0.0, 1.0)
GRID = 2.0**-10
ROUNDING = 1e-13  # m: lengths are about 1 m, crossings of edges are computed in a few operations


def cross(o, p, q):
    return (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])


def convex(points):
    """Corners of the convex hull, counterclockwise (Andrew's chain; exact on integers)."""
    points = sorted(set(points))
    chains = []
    for ordered in (points, points[::-1]):
        chain = []
        for p in ordered:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return chains[0] + chains[1]


def clip(subject, window):
    """Overlap of two convex polygons (Sutherland & Hodgman) in fractions."""
    polygon = [tuple(map(Fraction, p)) for p in subject]
    for k, a in enumerate(window):
        b = window[(k + 1) % len(window)]
        clipped = []
        for i, p in enumerate(polygon):
            q = polygon[(i + 1) % len(polygon)]
            side_p, side_q = cross(a, b, p), cross(a, b, q)
            if side_p >= 0:
                clipped.append(p)
            if side_p * side_q < 0:
                t = side_p / (side_p - side_q)
                clipped.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
        polygon = list(dict.fromkeys(clipped))
    if len(polygon) < 3:
        return []
    # Corners on a straight line carry nothing.
    n = len(polygon)
    return [p for i, p in enumerate(polygon) if cross(polygon[i - 1], p, polygon[(i + 1) % n]) != 0]


def area(polygon):
    """Twice the area."""
    return sum(cross((0, 0), p, polygon[(i + 1) % len(polygon)]) for i, p in enumerate(polygon))


def random_polygon(rng, corners):
    return convex([tuple(int(v) for v in rng.integers(-512, 513, 2)) for _ in range(corners)])


def prism(polygon, low, high):
    points = np.array(polygon, float) * GRID
    return core.ConvexHull([(x, y, z) for x, y in points for z in (low, high)])


def box_of(rng):
    """A box, the middle of its footprint, and its footprint."""
    half, middle = rng.integers(64, 512, 2), rng.integers(-256, 257, 2)
    corners = [
        (int(middle[0] + x * half[0]), int(middle[1] + y * half[1]))
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return core.Box((*(half * GRID), 0.5)), middle * GRID, corners


def sines(corners):
    """Sine of the angle between the edges that meet in each corner."""
    edge = np.roll(corners, -1, axis=0) - corners
    edge /= np.linalg.norm(edge, axis=1)[:, None]
    before = np.roll(edge, 1, axis=0)
    return np.abs(before[:, 0] * edge[:, 1] - before[:, 1] * edge[:, 0])


def check(upper, upper_at, lower, lower_at, subject, window):
    found = core.find_contacts(upper, upper_at, IDENTITY, lower, lower_at, IDENTITY, 1e-6)
    exact = clip(subject, window)
    if not exact:
        return False
    assert (np.abs(found["normal"] - (0, 0, 1)) <= 1e-15).all()
    assert (np.abs(found["separation"]) <= ROUNDING).all()
    corners = np.array([[float(x), float(y)] for x, y in exact]) * GRID
    points = found["point_b"][:, :2]
    apart = np.linalg.norm(points[:, None] - corners[None], axis=2)
    # Where edges cross at a small angle, rounding across them is carried along them.
    rounding = ROUNDING / sines(corners)
    assert (apart <= rounding).any(axis=1).all()  # nothing but corners of the overlap
    if len(exact) <= 8:
        assert (apart <= rounding).any(axis=0).all()  # all of them
    else:
        assert len(points) == 8
        # Eight corners of a disc keep 0.90 of its area, the least of any outline; thinning one corner
        # after another may end a little below.
        kept = convex([exact[i] for i in apart.argmin(axis=1)])
        assert area(kept) >= Fraction(8, 10) * area(exact)
    return True


@pytest.mark.parametrize("seed", range(100))
def test_prism_on_prism(seed):
    rng = np.random.default_rng(seed)
    subject, window = (random_polygon(rng, n) for n in rng.integers(3, 14, 2))
    if min(len(subject), len(window)) < 3:
        pytest.skip("a polygon came out flat")
    check(prism(subject, 0.0, 0.5), (0, 0, 0), prism(window, -0.5, 0.0), (0, 0, 0), subject, window)


@pytest.mark.parametrize("seed", range(50))
def test_box_on_box(seed):
    rng = np.random.default_rng(seed)
    upper, at_upper, subject = box_of(rng)
    lower, at_lower, window = box_of(rng)
    check(upper, (*at_upper, 0.5), lower, (*at_lower, -0.5), subject, window)


@pytest.mark.parametrize("seed", range(50))
def test_prism_on_box_and_box_on_prism(seed):
    rng = np.random.default_rng(seed)
    box, at, footprint = box_of(rng)
    polygon = random_polygon(rng, 12)
    check(prism(polygon, 0.0, 0.5), (0, 0, 0), box, (*at, -0.5), polygon, footprint)
    check(box, (*at, 0.5), prism(polygon, -0.5, 0.0), (0, 0, 0), footprint, polygon)


@pytest.mark.soak
def test_many_prisms():
    met = 0
    for seed in range(100_000):
        rng = np.random.default_rng(seed)
        subject, window = (random_polygon(rng, n) for n in rng.integers(3, 14, 2))
        if min(len(subject), len(window)) >= 3:
            met += check(
                prism(subject, 0.0, 0.5),
                (0, 0, 0),
                prism(window, -0.5, 0.0),
                (0, 0, 0),
                subject,
                window,
            )
    assert met > 50_000
