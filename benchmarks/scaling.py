"""How time and memory grow with the number of bodies: ``python -m benchmarks.scaling [--plot FILE]``.

Each size is built, settled and measured by itself: least of five blocks of steps. The exponent is the
slope of log time over log size.
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import rb_physics as rb

from .engines import scenes
from .engines.engine_rb_physics import shape_of
from .engines.penetration import separations
from .engines.scene import Scene


def build(scene: Scene, threads: int = 1) -> rb.World:
    world = rb.World(dt=scene.dt, threads=threads)
    surface = {"friction": scene.friction, "restitution": scene.restitution}
    for item in scene.items:
        world.add_body(
            shape_of(item.shape),
            mass=item.mass,
            position=item.position,
            orientation=item.orientation,
            **surface,
        )
    for plane in scene.planes:
        world.add_body(rb.HalfSpace(plane.normal, plane.offset), type="static", **surface)
    return world


def seconds_per_step(world: rb.World, warm_up: int, block: int, blocks: int = 5) -> float:
    world.step(warm_up)
    times = []
    for _ in range(blocks):
        start = time.perf_counter()
        world.step(block)
        times.append((time.perf_counter() - start) / block)
    return min(times)


def resident() -> int:
    """Bytes of this process in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def exponent(sizes: Sequence[int], times: Sequence[float]) -> float:
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])


SERIES: dict[str, tuple[Callable[[int], Scene], Sequence[int], int, int]] = {
    # name: scene of a size, sizes, steps before the clock, steps per block
    "separate boxes at rest": (scenes.resting, (100, 300, 1000, 3000, 10000), 10, 3),
    "separate boxes in flight": (scenes.separate, (100, 300, 1000, 3000, 10000), 5, 3),
    "pile of boxes": (scenes.pile, (100, 300, 666, 1000, 2000, 4000), 60, 3),
    "heap of spheres": (lambda n: scenes.heap("spheres", n), (100, 666, 1000, 4000), 3, 1),
    "heap of boxes": (lambda n: scenes.heap("boxes", n), (100, 666, 1000, 4000), 3, 1),
}


def measure(name: str, threads: int, cap: float) -> tuple[list[int], list[float], list[int]]:
    """Sizes, s per step, contacts; sizes that would take longer than ``cap`` s are left out."""
    make, sizes, warm_up, block = SERIES[name]
    done: list[int] = []
    times: list[float] = []
    contacts: list[int] = []
    for n in sizes:
        if times and times[-1] * (n / done[-1]) ** 1.2 * (warm_up + 5 * block) > cap:
            print(f"{name}: {n} bodies left out, above {cap:g} s", flush=True)
            break
        scene = make(n)
        world = build(scene, threads)
        times.append(seconds_per_step(world, warm_up, block))
        done.append(n)
        contacts.append(world.stats.contacts)
        poses = np.asarray(world.positions)[:n], np.asarray(world.orientations)[:n]
        gaps = separations(scene, *poses)
        depth = float(np.percentile(np.maximum(0.0, -gaps), 99)) if len(gaps) else 0.0
        per_body = 1e6 * times[-1] / n
        per_contact = f"{1e6 * times[-1] / contacts[-1]:8.2f}" if contacts[-1] else "       –"
        print(
            f"{name:26s} {threads} thread{'s' * (threads > 1)} {n:6d} {1e3 * times[-1]:9.3f} ms "
            f"{per_body:8.2f} µs/body {per_contact} µs/contact "
            f"penetration, 99 % {depth:.1e} m",
            flush=True,
        )
    return done, times, contacts


def memory() -> tuple[float, float]:
    """Bytes per body in flight and per contact, from the growth of the process."""

    def growth(make: Callable[[int], Scene], n: int) -> tuple[int, int]:
        gc.collect()
        before = resident()
        world = build(make(n))
        world.step(3)
        return resident() - before, world.stats.contacts

    growth(scenes.resting, 200)  # what is loaded on first use
    flying, _ = growth(scenes.separate, 4000)
    resting, contacts = growth(scenes.resting, 4000)
    return flying / 4000, max(0.0, (resting - flying) / contacts)


def plot(results: dict[str, tuple[list[int], list[float]]], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, panel = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for label, (sizes, times) in results.items():
        panel.loglog(sizes, np.multiply(times, 1e3), "o-", label=label)
    panel.set_xlabel("bodies")
    panel.set_ylabel("ms per step")
    panel.grid(which="both", alpha=0.3)
    panel.legend(fontsize=8)
    figure.savefig(path, dpi=100)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scaling", description=__doc__)
    parser.add_argument("--plot", type=Path, help="draw time over size into this file")
    parser.add_argument("--series", default="", help="only those whose name contains this")
    parser.add_argument("--cap", type=float, default=60.0, help="s per size (60)")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    arguments = parser.parse_args()
    if not arguments.series:
        body, contact = memory()
        print(f"memory: {body / 1024:.1f} KiB per body, {contact / 1024:.1f} KiB per contact")
    results = {}
    for name in (name for name in SERIES if arguments.series in name):
        seen: dict[int, list[float]] = {}
        for threads in arguments.threads:
            sizes, times, _ = measure(name, threads, arguments.cap)
            seen[threads] = times
            results[f"{name}, {threads} thread{'s' * (threads > 1)}"] = (sizes, times)
            if len(sizes) > 1:
                print(f"{name}: exponent {exponent(sizes, times):.2f}")
        for threads, times in seen.items():
            if threads > 1 and 1 in seen and times:
                k = min(len(times), len(seen[1])) - 1
                print(f"{name}: {threads} threads {seen[1][k] / times[k]:.2f} times as fast")
    if arguments.plot:
        plot(results, arguments.plot)


if __name__ == "__main__":
    main()
