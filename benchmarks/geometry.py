"""ns per narrow-phase query for each pair of shapes, beside coal on the same poses in one run.

`python -m benchmarks.geometry`. Three situations: far apart (most pairs of a broad phase), near or
touching, and overlapping. Ours gives the whole manifold, coal one contact. Both loop in C++: coal's
loop (coal_loop.cpp) is compiled against the headers its wheel brings; without them or a compiler its
column stays empty.
"""

from __future__ import annotations

import importlib.util
import itertools
import os
import shlex
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from rb_physics import _core as core


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


def _coal_loop(folder: str) -> str | None:
    """Compiles coal's loop; its path, or None where that is not possible."""
    spec = importlib.util.find_spec("coal")
    if spec is None or spec.origin is None:
        return None
    prefix = next((p for p in Path(spec.origin).parents if p.name == "cmeel.prefix"), None)
    if prefix is None:
        prefix = next((p / "cmeel.prefix" for p in Path(spec.origin).parents), None)
    if prefix is None or not (prefix / "include/coal/collision.h").is_file():
        return None
    program = f"{folder}/coal_loop"
    command = [
        *shlex.split(os.environ.get("CXX", "g++")),
        *("-std=c++17", "-O3", "-isystem", f"{prefix}/include"),
        *("-isystem", f"{prefix}/include/eigen3", str(Path(__file__).with_name("coal_loop.cpp"))),
        *("-o", program, f"-L{prefix}/lib", "-lcoal", f"-Wl,-rpath,{prefix}/lib"),
    ]
    try:
        built = subprocess.run(command, capture_output=True, text=True, timeout=600)
    except OSError:
        return None
    return program if built.returncode == 0 else None


def _described(shape) -> str:
    if isinstance(shape, core.Sphere):
        return f"sphere {shape.radius}"
    if isinstance(shape, core.Capsule):
        return f"capsule {shape.radius} {shape.half_length}"
    if isinstance(shape, core.Cylinder):
        return f"cylinder {shape.radius} {shape.half_length}"
    if isinstance(shape, core.Box):
        return "box " + " ".join(map(str, shape.half_extents))
    numbers = " ".join(repr(float(x)) for x in shape.points.ravel())
    return f"hull {len(shape.points)} {numbers}"


def _coal_ns(program: str, a, b, poses: np.ndarray, margin: float) -> float:
    rows = "\n".join(" ".join(repr(float(x)) for x in row) for row in poses)
    text = f"{_described(a)} {_described(b)} {margin} {len(poses)}\n{rows}\n"
    done = subprocess.run([program], input=text, capture_output=True, text=True, timeout=120)
    return float(done.stdout)


def run(poses: int = 2000) -> list[dict]:
    """One row per pair and situation: pair, situation, ns, coal_ns (None without coal)."""
    with tempfile.TemporaryDirectory() as folder:
        return _rows(poses, _coal_loop(folder))


def _rows(poses: int, program: str | None) -> list[dict]:
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
                    "coal_ns": _coal_ns(program, a, b, placed, margin) if program else None,
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
