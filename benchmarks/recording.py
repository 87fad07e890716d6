"""What recording costs: CPU time per step, bytes per body and second, making the view, seeking.

    python -m benchmarks.recording [--seconds 5] [--scene hundred_bodies]

CPU times of the process, all its threads together: they don't depend on how busy the machine is
as much as wall times do. The run is as fast as it can be, with every topic at its packaged rate.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.render import write_rrd
from rb_physics.recording.replay import verify


def run(scene: Any, seconds: float, directory: Path | None, rerun: str) -> tuple[float, dict]:
    """CPU s per step and the recorder's counters; None: outputs only, or not even those ("none")."""
    world = scene.build()
    steps = round(seconds / world.dt)
    started = time.process_time()
    if rerun == "none":
        for _ in range(steps):
            world.step()
        return (time.process_time() - started) / steps, {}
    with Recorder(world, directory, scene=scene, rerun=rerun) as recorder:
        for _ in range(steps):
            world.step()
            recorder.after_step()
    return (time.process_time() - started) / steps, recorder.counters


def seek_times(path: Path, seconds: float) -> list[float]:
    """s of wall time to the first poses at or after 50 moments."""
    times = []
    with open(path, "rb") as file:
        reader = make_reader(file)
        reader.get_summary()
        for k in range(50):
            moment = int(seconds * 1e9 * ((k * 37) % 50) / 50)
            started = time.perf_counter()
            next(reader.iter_messages(topics=["/sim_node/poses"], start_time=moment), None)
            times.append(time.perf_counter() - started)
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=5.0, help="simulated time")
    parser.add_argument("--scene", default="hundred_bodies")
    options = parser.parse_args()
    scene = rb.load_scene(options.scene)
    bodies = len(scene.bodies)
    print(f"{options.scene}: {bodies} bodies, {options.seconds:g} s at dt {scene.build().dt:g} s")
    with tempfile.TemporaryDirectory() as folder:
        base, last = Path(folder), 0.0
        for name, directory, rerun in (
            ("simulation alone", None, "none"),
            ("and outputs encoded", None, "off"),
            ("and the bag", base / "bag", "off"),
            ("and the Rerun view", base / "view", "file"),
        ):
            cost, counters = run(scene, options.seconds, directory, rerun)
            print(f"{name:<22} {cost * 1e6:8.0f} us CPU per step  (+{(cost - last) * 1e6:.0f})")
            last = cost
        size = sum(p.stat().st_size for p in (base / "bag").glob("*.mcap"))
        print(
            f"bag: {size / 1e6:.1f} MB, {size / bodies / options.seconds:.0f} bytes per body and "
            f"second, {counters['messages']} messages, {counters['dropped']} dropped"
        )
        started = time.process_time()
        write_rrd(base / "bag", base / "bag.rrd")
        spent = time.process_time() - started
        print(f"view from the bag: {options.seconds / spent:.1f} times real time (CPU)")
        started = time.process_time()
        count = sum(1 for _ in Recording(base / "bag").messages())
        print(f"reading: {(time.process_time() - started) / count * 1e6:.1f} us per message")
        seeks = seek_times(base / "bag" / "bag_0.mcap", options.seconds)
        print(
            f"seek: median {statistics.median(seeks) * 1e3:.1f} ms, worst {max(seeks) * 1e3:.1f} ms"
        )
        print(verify(base / "bag").text)


if __name__ == "__main__":
    main()
