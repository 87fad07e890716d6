"""How deep bodies are in one another, from poses alone; the one judge of every engine's accuracy.

Separating axes: the separation of two convex polytopes is the largest gap over the normals of their
faces and the cross products of their edges; where it is negative, that is the penetration depth.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from .scene import Ball, Block, Hull, Item, Plane, Scene, Shape

TOUCHING = 1e-3  # m: pairs closer than this count as contacts


@dataclass(frozen=True)
class Axes:
    vertices: np.ndarray  # (V, 3)
    normals: np.ndarray  # (F, 3), opposite ones once
    edges: np.ndarray  # (E, 3), parallel ones once


def directions(vectors: np.ndarray) -> np.ndarray:
    """Unit vectors, parallel and opposite ones once."""
    kept: list[np.ndarray] = []
    for v in vectors / np.linalg.norm(vectors, axis=1)[:, None]:
        if all(abs(v @ k) < 1 - 1e-12 for k in kept):
            kept.append(v)
    return np.array(kept)


@cache
def axes_of(shape: Block | Hull) -> Axes:
    if isinstance(shape, Block):
        corners = np.array(list(itertools.product((-1, 1), repeat=3))) * shape.half
        return Axes(corners, np.eye(3), np.eye(3))
    v = np.array(shape.vertices)
    reach = np.abs(v).max()
    normals, edges = [], []
    for i, j, k in itertools.combinations(range(len(v)), 3):
        n = np.cross(v[j] - v[i], v[k] - v[i])
        if np.linalg.norm(n) < 1e-9 * reach**2:
            continue
        height = (v - v[i]) @ (n / np.linalg.norm(n))
        if height.max() < 1e-9 * reach or height.min() > -1e-9 * reach:
            normals.append(n)
            edges += [v[j] - v[i], v[k] - v[i], v[k] - v[j]]
    return Axes(v, directions(np.array(normals)), directions(np.array(edges)))


def rotations(q: np.ndarray) -> np.ndarray:
    """(N, 3, 3) of quaternions (N, 4), x y z w."""
    x, y, z, w = (q / np.linalg.norm(q, axis=1)[:, None]).T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)


def radius(shape: Shape) -> float:
    """m, of the smallest ball about the origin that holds the shape."""
    if isinstance(shape, Ball):
        return shape.radius
    return float(np.linalg.norm(axes_of(shape).vertices, axis=1).max())


def near_pairs(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    """(P, 2) pairs of balls of centres x and radii r that come within TOUCHING; a sweep along x."""
    order = np.argsort(x[:, 0] - r)
    low, high = (x[:, 0] - r)[order], (x[:, 0] + r + TOUCHING)[order]
    last = np.searchsorted(low, high)
    found = []
    for k, i in enumerate(order):
        others = order[k + 1 : last[k]]
        gap = np.linalg.norm(x[others] - x[i], axis=1) - r[others] - r[i]
        found += [(i, j) for j in others[gap < TOUCHING]]
    return np.array(found, int).reshape(-1, 2)


def polytope_gaps(
    a: Axes, b: Axes, ra: np.ndarray, rb: np.ndarray, shift: np.ndarray
) -> np.ndarray:
    """(P,) separations in m of polytopes a and b turned by ra and rb, b shifted by ``shift``."""
    va, vb = a.vertices @ ra.transpose(0, 2, 1), b.vertices @ rb.transpose(0, 2, 1)
    vb = vb + shift[:, None]
    ea, eb = a.edges @ ra.transpose(0, 2, 1), b.edges @ rb.transpose(0, 2, 1)
    cross = np.cross(ea[:, :, None], eb[:, None, :]).reshape(len(shift), -1, 3)
    size = np.linalg.norm(cross, axis=2, keepdims=True)
    parallel = size < 1e-6  # their axis is between those of faces
    cross = np.where(
        parallel, a.normals[0] @ ra.transpose(0, 2, 1)[:, None], cross / np.where(parallel, 1, size)
    )
    axes = np.concatenate(
        [a.normals @ ra.transpose(0, 2, 1), b.normals @ rb.transpose(0, 2, 1), cross], axis=1
    )
    pa, pb = axes @ va.transpose(0, 2, 1), axes @ vb.transpose(0, 2, 1)
    gap = np.maximum(pa.min(2) - pb.max(2), pb.min(2) - pa.max(2))
    return gap.max(1)


def plane_gaps(items: Sequence[Item], plane: Plane, x: np.ndarray, turn: np.ndarray) -> list[float]:
    n = np.array(plane.normal)
    height = x @ n - plane.offset
    gaps = []
    for i, item in enumerate(items):
        if item.kinematic:
            continue
        if isinstance(item.shape, Ball):
            gaps.append(height[i] - item.shape.radius)
        else:
            gaps.append(height[i] + (axes_of(item.shape).vertices @ (turn[i].T @ n)).min())
    return gaps


def separations(scene: Scene, positions: np.ndarray, orientations: np.ndarray) -> np.ndarray:
    """Separations in m of all contacts: pairs closer than TOUCHING; negative where they overlap."""
    items, turn = scene.items, rotations(orientations)
    gaps: list[float] = []
    for plane in scene.planes:
        gaps += plane_gaps(items, plane, positions, turn)
    groups: dict[tuple[Shape, Shape], list[tuple[int, int]]] = defaultdict(list)
    for i, j in near_pairs(positions, np.array([radius(item.shape) for item in items])):
        if not (items[i].kinematic and items[j].kinematic):
            groups[items[i].shape, items[j].shape].append((i, j))
    for (a, b), pairs in groups.items():
        for start in range(0, len(pairs), 256):
            i, j = np.array(pairs[start : start + 256]).T
            shift = positions[j] - positions[i]
            if isinstance(a, Ball) and isinstance(b, Ball):
                gaps += list(np.linalg.norm(shift, axis=1) - a.radius - b.radius)
            elif isinstance(a, Ball) or isinstance(b, Ball):
                raise NotImplementedError("balls beside polytopes")
            else:
                gaps += list(polytope_gaps(axes_of(a), axes_of(b), turn[i], turn[j], shift))
    found = np.array(gaps)
    return found[found < TOUCHING]
