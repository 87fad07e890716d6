"""ns per narrow-phase query for each pair of shapes, beside coal on the same poses in one run.

Three situations: far apart (most pairs of a broad phase), near or touching, and overlapping. Ours gives
the whole manifold; coal gives one contact. Python's cost of a call is taken off coal's time by
timing an empty collision call; ours loops inside the core.
"""

from __future__ import annotations

import itertools
import time

import numpy as np

from rb_physics import _core as core

try:
    import coal
except ImportError:  # pragma: no cover
    coal = None


def shapes() -> dict:
    rng = np.random.default_rng(0)
    return {
        "sphere": core.Sphere(0.3),
        "capsule": core.Capsule(0.2, 0.2),
        "cylinder": core.Cylinder(0.25, 0.25),
        "box": core.Box((0.2, 0.25, 0.3)),
        "hull20": core.ConvexHull(_on_sphere(rng, 20)),
        "hull100": core.ConvexHull(_on_sphere(rng, 100)),
    }


def _on_sphere(rng: np.random.Generator, n: int) -> np.ndarray:
    p = rng.normal(size=(n, 3))
    return 0.3 * p / np.linalg.norm(p, axis=1)[:, None]


def _poses(rng: np.random.Generator, n: int, gap: float) -> np.ndarray:
    q = rng.normal(size=(2, n, 4))
    q /= np.linalg.norm(q, axis=2)[..., None]
    d = rng.normal(size=(n, 3))
    d *= gap / np.linalg.norm(d, axis=1)[:, None]
    return np.hstack([d, q[0], np.zeros((n, 3)), q[1]])


def _coal_shape(shape):
    if isinstance(shape, core.Sphere):
        return coal.Sphere(shape.radius)
    if isinstance(shape, core.Capsule):
        return coal.Capsule(shape.radius, 2 * shape.half_length)
    if isinstance(shape, core.Cylinder):
        return coal.Cylinder(shape.radius, 2 * shape.half_length)
    if isinstance(shape, core.Box):
        return coal.Box(*(2 * h for h in shape.half_extents))
    points = coal.StdVec_Vec3s()
    for p in shape.points:
        points.append(p)
    return coal.Convex.convexHull(points, False, "Qt")


def _coal_ns(a, b, poses: np.ndarray, margin: float) -> float:
    """Best of three passes of coal.collide with a contact, less the cost of an empty call."""
    transforms = []
    for row in poses:
        pair = []
        for k in (0, 7):
            quat = coal.Quaternion(row[k + 6], row[k + 3], row[k + 4], row[k + 5])
            pair.append(coal.Transform3s(quat, row[k : k + 3]))
        transforms.append(pair)
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    request.security_margin = margin
    request.enable_contact = True

    def run(x, y, placed):
        best = np.inf
        for _ in range(3):
            start = time.perf_counter()
            for t, u in placed:
                result.clear()
                coal.collide(x, t, y, u, request, result)
            best = min(best, time.perf_counter() - start)
        return best / len(placed) * 1e9

    far = [(coal.Transform3s(np.eye(3), np.array([9.0, 0, 0])), coal.Transform3s())] * len(poses)
    ball = coal.Sphere(0.1)
    return run(_coal_shape(a), _coal_shape(b), transforms) - run(ball, ball, far)


def run(poses: int = 2000) -> list[dict]:
    """One row per pair and situation: pair, situation, ns, coal_ns (None without coal)."""
    rows = []
    for (name_a, a), (name_b, b) in itertools.combinations_with_replacement(shapes().items(), 2):
        for situation, gap, margin in (
            ("apart", 1.5, 0.01),
            ("near", 0.55, 0.01),
            ("deep", 0.2, 0.0),
        ):
            placed = _poses(np.random.default_rng(7), poses, gap)
            seconds, _ = core.time_find_contacts(a, b, placed, margin, 5)
            rows.append(
                {
                    "pair": f"{name_a}-{name_b}",
                    "situation": situation,
                    "ns": seconds / poses * 1e9,
                    "coal_ns": _coal_ns(a, b, placed, margin) if coal else None,
                }
            )
    return rows


def main() -> None:
    print(f"{'pair':22} {'situation':9} {'ns':>8} {'coal ns':>8} {'ratio':>6}")
    for row in run():
        theirs = row["coal_ns"]
        beside = f"{theirs:8.0f} {theirs / row['ns']:6.1f}" if theirs else ""
        print(f"{row['pair']:22} {row['situation']:9} {row['ns']:8.0f} {beside}")


if __name__ == "__main__":
    main()
