"""Cost of the broad phase against the number of bodies: `python benchmarks/broad_phase.py`.

Boxes of equal size at constant density, so the number of pairs grows like n and O(n log n) shows as
a nearly constant time per body. Columns, microseconds per body: building the tree, one update with
every body moving (0.1 to 10 % of its size per step), one update with every body at rest.
"""

import argparse
import time

import numpy as np

from rb_physics import _core


def best(function, repeats):
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def measure(n, repeats=5, density=0.3):
    """Times in seconds: (build, moving, resting), and the number of pairs."""
    rng = np.random.default_rng(0)
    lower = rng.uniform(0, (n / density) ** (1 / 3), (n, 3))
    upper = lower + 1.0
    velocity = rng.uniform(-0.1, 0.1, (n, 3)) * rng.uniform(0.01, 1, (n, 1))

    start = time.perf_counter()
    broad = _core.BroadPhase()
    for low, high in zip(lower, upper, strict=True):
        broad.insert(low, high)
    pairs = broad.update_count()
    build = time.perf_counter() - start

    step = [0]

    def move():
        step[0] += 1
        shift = step[0] * velocity
        broad.move_all(lower + shift, upper + shift, velocity)
        broad.update_count()

    def rest():
        broad.move_all(lower + step[0] * velocity, upper + step[0] * velocity)
        broad.update_count()

    moving = np.mean([best(move, 1) for _ in range(4 * repeats)])
    rest()
    return build, moving, best(rest, repeats), pairs


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--largest", type=int, default=100_000)
    args = parser.parse_args()
    print(f"{'bodies':>8} {'pairs':>9} {'build':>8} {'moving':>8} {'resting':>8}   us per body")
    n = 100
    while n <= args.largest:
        build, moving, resting, pairs = measure(n)
        us = 1e6 / n
        print(f"{n:8d} {pairs:9d} {build * us:8.3f} {moving * us:8.3f} {resting * us:8.3f}")
        n *= 10


if __name__ == "__main__":
    main()
