"""Makes heaps.npz, the poses from which every engine starts the heaps.

PhysX throws the bodies into the bin and lets them rest; then all positions are stretched until
nothing overlaps, so that no engine starts with the errors of another. Stored as int16: positions in
0.2 mm, quaternions in 1/32767.
"""

from __future__ import annotations

import itertools

import numpy as np

from . import scenes
from .penetration import separations
from .scene import Item, Scene


def thrown(kind: str, count: int) -> Scene:
    random = np.random.default_rng(count)
    planes = scenes.bin_planes(count)
    half = -planes[1].offset
    side = max(1, int((half - 0.2) / 0.17))
    ticks = np.linspace(-half + 0.23, half - 0.23, side)
    items = []
    for k, shape in enumerate(scenes.shapes_of(kind, count)):
        layer, place = divmod(k, side * side)
        q = random.normal(size=4)
        astray = 0.05 * random.uniform(-1, 1, 2)  # columns would stay columns
        where = (
            ticks[place % side] + astray[0],
            ticks[place // side] + astray[1],
            0.2 + 0.33 * layer,
        )
        items.append(Item(shape, where, tuple(q / np.linalg.norm(q))))
    return Scene(kind, items, 5e-3, 0, 1, 1, planes, friction=0.2)


def packed(x: np.ndarray, q: np.ndarray) -> np.ndarray:
    return np.concatenate([x / scenes.UNIT, q * 32767], axis=1).round().astype(np.int16)


def main() -> None:
    from .engine_physx import PhysX

    heaps = {}
    for count, kind in itertools.product(scenes.SIZES, scenes.KINDS):
        scene = thrown(kind, count)
        engine = PhysX(scene)
        engine.step(700)
        x, q = engine.poses()
        stretch = 1.0
        while True:
            poses = packed(stretch * x, q)
            y, p = (
                poses[:, :3] * scenes.UNIT,
                poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1)[:, None],
            )
            # The walls give way: only bodies may not overlap, and heaps are stretched upwards from the floor.
            inside = Scene(kind, scene.items, 5e-3, 0, 1, 1, ())
            least = separations(inside, y, p).min(initial=1.0)
            if least > 0:
                break
            stretch += 0.002
        print(
            kind,
            count,
            f"stretched by {stretch - 1:.1%}, highest {y[:, 2].max():.2f} m",
            flush=True,
        )
        heaps[f"{kind}_{count}"] = poses
        np.savez_compressed(scenes.HEAPS, **heaps)


if __name__ == "__main__":
    main()
