"""Independent answers for geometry: support functions, membership, brute-force separating axes.

Shapes are the library's own classes (plain data); nothing of the library's arithmetic is used.
Poses are (position (3,), orientation (x, y, z, w)).
"""

from __future__ import annotations

import itertools

import numpy as np

from rb_physics import _core as core

Pose = tuple[np.ndarray, np.ndarray]


def rotation(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def random_orientation(rng: np.random.Generator) -> np.ndarray:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def vertices(shape) -> np.ndarray:
    """Corners (n, 3) of a polytope in its own coordinates."""
    if isinstance(shape, core.Box):
        signs = np.array(list(itertools.product((-1, 1), repeat=3)))
        return signs * np.asarray(shape.half_extents)
    return shape.points


def reach(shape, pose: Pose, n: np.ndarray) -> float:
    """Support function: the largest n . x over the placed shape."""
    position, q = pose
    d = rotation(q).T @ n
    if isinstance(shape, core.Particle):
        r = 0.0
    elif isinstance(shape, core.Sphere):
        r = shape.radius * np.linalg.norm(d)
    elif isinstance(shape, core.Capsule):
        r = shape.radius * np.linalg.norm(d) + shape.half_length * abs(d[2])
    elif isinstance(shape, core.Cylinder):
        r = shape.radius * np.hypot(d[0], d[1]) + shape.half_length * abs(d[2])
    else:
        r = (vertices(shape) @ d).max()
    return float(n @ position + r)


def reaches(shape, pose: Pose, n: np.ndarray) -> np.ndarray:
    """`reach` for many directions (k, 3)."""
    d = n @ rotation(pose[1])
    r = np.zeros(len(n))
    if isinstance(shape, core.Sphere):
        r = shape.radius * np.linalg.norm(d, axis=1)
    elif isinstance(shape, core.Capsule):
        r = shape.radius * np.linalg.norm(d, axis=1) + shape.half_length * np.abs(d[:, 2])
    elif isinstance(shape, core.Cylinder):
        r = shape.radius * np.hypot(d[:, 0], d[:, 1]) + shape.half_length * np.abs(d[:, 2])
    elif not isinstance(shape, core.Particle):
        r = (d @ vertices(shape).T).max(axis=1)
    return n @ pose[0] + r


def searched_separation(a, pose_a: Pose, b, pose_b: Pose) -> float:
    """Greatest separation over directions by search: from below, to about 1e-9 where it is smooth."""
    rng = np.random.default_rng(0)

    def gaps(n):
        return -reaches(a, pose_a, -n) - reaches(b, pose_b, n)

    n = rng.normal(size=(3000, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    found = gaps(n)
    best = -np.inf
    for start in np.argsort(found)[-40::8]:
        center, value, width = n[start], found[start], 0.1
        while width > 1e-9:
            near = center + width * rng.normal(size=(60, 3))
            near /= np.linalg.norm(near, axis=1)[:, None]
            tried = gaps(near)
            if tried.max() > value:
                center, value = near[tried.argmax()], tried.max()
            else:
                width *= 0.5
        best = max(best, value)
    return float(best)


def separation_along(a, pose_a: Pose, b, pose_b: Pose, n: np.ndarray) -> float:
    """Width of the gap between the shapes along n (from b to a); minus the overlap."""
    return -reach(a, pose_a, -n) - reach(b, pose_b, n)


def outside(shape, pose: Pose, point: np.ndarray) -> float:
    """How far a point lies outside of the placed shape, m (exact where it matters: 0 inside)."""
    x = rotation(pose[1]).T @ (point - pose[0])
    if isinstance(shape, core.Particle):
        return float(np.linalg.norm(x))
    if isinstance(shape, core.Sphere):
        return max(0.0, float(np.linalg.norm(x)) - shape.radius)
    if isinstance(shape, core.Box):
        return float(np.linalg.norm(np.maximum(np.abs(x) - shape.half_extents, 0)))
    if isinstance(shape, core.Capsule):
        axis = np.array([0, 0, np.clip(x[2], -shape.half_length, shape.half_length)])
        return max(0.0, float(np.linalg.norm(x - axis)) - shape.radius)
    if isinstance(shape, core.Cylinder):
        across = max(np.hypot(x[0], x[1]) - shape.radius, 0)
        return float(np.hypot(across, max(abs(x[2]) - shape.half_length, 0)))
    if isinstance(shape, core.HalfSpace):
        return max(0.0, float(np.dot(shape.normal, x)) - shape.offset)
    normals, offsets = face_planes(shape)
    return max(0.0, float((normals @ x - offsets).max()))


def face_planes(shape) -> tuple[np.ndarray, np.ndarray]:
    """Outward unit normals and offsets of a polytope's faces."""
    if isinstance(shape, core.Box):
        normals = np.vstack([np.eye(3), -np.eye(3)])
        return normals, np.tile(shape.half_extents, 2)
    points, normals, offsets = shape.points, [], []
    center = points.mean(axis=0)
    for face in shape.faces:
        p = points[face]
        n = sum(np.cross(p[i] - p[0], p[i + 1] - p[0]) for i in range(1, len(p) - 1))
        n = n / np.linalg.norm(n)
        normals.append(n if n @ (p[0] - center) > 0 else -n)
        offsets.append(normals[-1] @ p[0])
    return np.array(normals), np.array(offsets)


def edge_directions(shape) -> np.ndarray:
    if isinstance(shape, core.Box):
        return np.eye(3)
    d = shape.points[shape.edges[:, 1]] - shape.points[shape.edges[:, 0]]
    return d / np.linalg.norm(d, axis=1)[:, None]


def brute_force_separation(a, pose_a: Pose, b, pose_b: Pose) -> float:
    """Greatest separation over every axis two polytopes can have: minus the penetration depth."""
    ra, rb = rotation(pose_a[1]), rotation(pose_b[1])
    va, vb = vertices(a) @ ra.T + pose_a[0], vertices(b) @ rb.T + pose_b[0]
    ea, eb = edge_directions(a) @ ra.T, edge_directions(b) @ rb.T
    crossed = np.cross(ea[:, None], eb[None]).reshape(-1, 3)
    length = np.linalg.norm(crossed, axis=1)
    keep = length > 1e-7  # parallel edges have no axis of their own
    axes = np.vstack(
        [
            face_planes(a)[0] @ ra.T,
            face_planes(b)[0] @ rb.T,
            crossed[keep] / length[keep][:, None],
        ]
    )
    axes = np.vstack([axes, -axes])
    gaps = (axes @ va.T).min(axis=1) - (axes @ vb.T).max(axis=1)
    return float(gaps.max())
