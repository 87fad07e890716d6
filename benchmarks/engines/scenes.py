"""The scenes, smallest first."""

from __future__ import annotations

import itertools
from functools import cache
from pathlib import Path

import numpy as np

from .scene import GROUND, Ball, Block, Hull, Item, Plane, Scene, Shape

HEAPS = Path(__file__).with_name("heaps.npz")
UNIT = 2e-4  # m, of stored positions
SIZES = (100, 666, 1000, 4000)
BOX = Block((0.1, 0.1, 0.1))


def octahedron(a: float, b: float, c: float) -> Hull:
    """|x|/a + |y|/b + |z|/c <= 1."""
    corners = [tuple(row) for s in (1, -1) for row in (s * np.diag([a, b, c])).tolist()]
    moments = np.square([a, b, c]) / 10  # means of x², y², z²
    return Hull(tuple(corners), 4 / 3 * a * b * c, tuple((moments.sum() - moments).tolist()))


def prism(radius: float, half: float) -> Hull:
    """Hexagonal, along z; ``radius`` of the circle about the hexagon."""
    angles = np.arange(6) * np.pi / 3
    ring = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = [(float(x), float(y), z) for z in (-half, half) for x, y in ring]
    moments = np.array([5 / 24 * radius**2, 5 / 24 * radius**2, half**2 / 3])
    volume = 3 * np.sqrt(3) * radius**2 * half
    return Hull(tuple(corners), float(volume), tuple((moments.sum() - moments).tolist()))


KINDS: dict[str, list[Shape]] = {
    "spheres": [Ball(0.08), Ball(0.1), Ball(0.12)],
    "boxes": [Block(h) for h in ((0.1, 0.1, 0.1), (0.08, 0.1, 0.12), (0.06, 0.12, 0.12))],
    "hulls": [
        octahedron(0.14, 0.14, 0.14),
        octahedron(0.12, 0.14, 0.16),
        prism(0.12, 0.08),
        prism(0.09, 0.13),
        Block((0.08, 0.1, 0.12)),
    ],
}


def shapes_of(kind: str, count: int) -> list[Shape]:
    some = KINDS[kind]
    return [some[k % len(some)] for k in range(count)]


def bin_planes(count: int) -> list[Plane]:
    """A floor and four walls, so wide that the heap is about as high."""
    half = 0.125 * round(count ** (1 / 3), 3) + 0.1
    sides = [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)]
    return [GROUND, *(Plane(side, -half) for side in sides)]


def heap(kind: str, count: int) -> Scene:
    """Thrown into a bin and at rest, but for gaps of some millimetres (`make_heaps.py`)."""
    with np.load(HEAPS) as stored:
        poses = stored[f"{kind}_{count}"].astype(float)
    x, q = poses[:, :3] * UNIT, poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    items = [
        Item(shape, tuple(x[k]), tuple(q[k])) for k, shape in enumerate(shapes_of(kind, count))
    ]
    return Scene(
        f"heap of {count} {kind}", items, 5e-3, 40, 12, 5, bin_planes(count), group=f"heap {kind}"
    )


def pile(count: int) -> Scene:
    """Layers of cubes, every second one shifted by half a cube, each cube a little astray."""
    random = np.random.default_rng(count)
    side = round(count ** (1 / 3) + 0.4)
    items = []
    for k in range(count):
        layer, place = divmod(k, side * side)
        row, column = divmod(place, side)
        shift = 0.1 * (layer % 2)
        x = (0.202 * column + shift, 0.202 * row + shift, 0.1 + 0.2005 * layer)
        yaw = 1e-3 * random.uniform(-1, 1)
        place_astray = np.array(x) + [*random.uniform(-2e-4, 2e-4, 2), 0]
        items.append(Item(BOX, tuple(place_astray), (0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2))))
    return Scene(f"pile of {count} boxes", items, 5e-3, 60, 12, 5, group="pile")


def tower(count: int) -> Scene:
    items = [Item(BOX, (0.0, 0.0, 0.1 + 0.2 * k)) for k in range(count)]
    return Scene(f"tower of {count}", items, 5e-3, 400, 16, 100, tower=True)


def separate(count: int) -> Scene:
    """Boxes that bounce, each for itself."""
    random = np.random.default_rng(1)
    side = int(np.ceil(np.sqrt(count)))
    items = []
    for k in range(count):
        q = random.normal(size=4)
        place = (1.0 * (k % side), 1.0 * (k // side), 0.5 + 0.5 * random.random())
        items.append(Item(BOX, place, tuple(q / np.linalg.norm(q))))
    return Scene(f"{count} separate bouncing boxes", items, 5e-3, 40, 20, 10, restitution=0.5)


def resting(count: int) -> Scene:
    side = int(np.ceil(np.sqrt(count)))
    items = [Item(BOX, (1.0 * (k % side), 1.0 * (k // side), 0.1)) for k in range(count)]
    return Scene(f"{count} resting boxes", items, 1e-3, 100, 20, 20)


def balls_666(dt: float) -> Scene:
    """SimBenchmark's 666 test: 6 x 6 x 6 balls let fall on a floor without friction."""
    items = []
    for i, j, k in itertools.product(range(6), repeat=3):
        # Every layer a little astray, so that columns do not balance.
        lean = 0.02 * k
        items.append(Item(Ball(0.5), (1.1 * i + lean, 1.1 * j + 0.5 * lean, 0.6 + 1.1 * k)))
    steps = round(5.0 / dt / 20)
    name = f"666 balls, dt {dt:g}"
    return Scene(name, items, dt, 0, 20, steps, friction=0.0, squared=True)


def conveyor() -> Scene:
    """60 boxes carried by 20 kinematic slats that move at 0.5 m/s."""
    slat = Block((0.1, 0.4, 0.05))
    items = [
        Item(slat, (0.2 * k, 0.0, -0.05), velocity=(0.5, 0.0, 0.0), kinematic=True)
        for k in range(20)
    ]
    for k in range(60):
        column, layer = k % 15, k // 15
        items.append(Item(BOX, (0.3 + 0.23 * column, 0.0, 0.1 + 0.2 * layer)))
    return Scene("conveyor, 20 kinematic slats, 60 boxes", items, 5e-3, 40, 16, 10, planes=())


def control_loop() -> Scene:
    """Ten boxes at 1 kHz, step by step: force in, step, poses out."""
    items = [Item(BOX, (0.4 * (k % 5), 0.4 * (k // 5), 0.1)) for k in range(10)]
    return Scene("10 boxes at 1 kHz from Python", items, 1e-3, 200, 20, 100, from_python=True)


def single() -> Scene:
    items = [Item(BOX, (0.0, 0.0, 0.1))]
    name = "one resting box from Python"
    return Scene(name, items, 1e-3, 1000, 20, 500, call_only=True)


@cache
def scenes() -> dict[str, Scene]:
    """By short name."""
    every = {
        "single": single(),
        "control": control_loop(),
        "resting-100": resting(100),
        "separate-1000": separate(1000),
        "tower-10": tower(10),
        "tower-30": tower(30),
        "conveyor": conveyor(),
        "balls-666-dt10ms": balls_666(1e-2),
        "balls-666-dt1ms": balls_666(1e-3),
        "pile-boxes-666": pile(666),
        "pile-boxes-1000": pile(1000),
    }
    if HEAPS.exists():
        for kind, count in itertools.product(KINDS, SIZES):
            every[f"heap-{kind}-{count}"] = heap(kind, count)
    return every
