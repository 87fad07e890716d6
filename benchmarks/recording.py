"""What recording costs: CPU time per step, bytes per body and second, memory, seeking, the view.

    python -m benchmarks.recording [--seconds 600] [--scene hundred_bodies]

CPU times are of the process, all its threads together, from short runs as fast as they can be, with
every topic at its packaged rate. Then one long run, whose bag is looked into, made into a view, and
sought in with this package and with the mcap package.
"""

from __future__ import annotations

import argparse
import gc
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.render import write_rrd
from rb_physics.recording.replay import verify

SHORT = 5.0  # s of simulated time whose cost is taken apart
TOPIC = "/sim_node/poses"


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


def resident() -> float:
    """MB of memory this process holds."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE") / 1e6


def long_run(scene: Any, seconds: float, directory: Path) -> None:
    """Records, and prints the memory held ten times on the way."""
    world = scene.build()
    steps = round(seconds / world.dt)
    held = []
    with Recorder(world, directory, scene=scene) as recorder:
        for step in range(1, steps + 1):
            world.step()
            recorder.after_step()
            if step % max(1, steps // 10) == 0:
                held.append(resident())
    print(
        "memory over the long run: " + " ".join(f"{mb:.0f}" for mb in held)
        + f" MB: {(held[-1] - held[1]) / (0.8 * seconds / 60):+.2f} MB a minute after the first fifth"
    )  # fmt: skip


def seek_times(look: Callable[[int], object], seconds: float) -> str:
    """ms of wall time and of CPU time to the first poses at or after 50 moments, as text."""
    walls, cpus = [], []
    look(0)
    gc.freeze()  # what was read on opening isn't looked through for garbage in the middle of a seek
    for k in range(50):
        moment = int(seconds * 1e9 * ((k * 37) % 50) / 50)
        wall, cpu = time.perf_counter(), time.thread_time()
        look(moment)
        cpus.append((time.thread_time() - cpu) * 1e3)
        walls.append((time.perf_counter() - wall) * 1e3)
    return (
        f"median {statistics.median(walls):.1f} ms, worst {max(walls):.1f} ms; "
        f"CPU {statistics.median(cpus):.1f} and {max(cpus):.1f} ms"
    )


def print_seeks(directory: Path, seconds: float) -> None:
    """In the whole recording with this package; in its first file with the mcap package."""
    recording = Recording(directory)
    recording.load_index()
    ours = seek_times(lambda moment: next(recording.messages({TOPIC}, moment), None), seconds)
    print(f"seek: {ours}")
    with open(recording.files[0], "rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        inside = summary.statistics.message_end_time / 1e9

        def look(moment: int) -> object:
            return next(reader.iter_messages(topics=[TOPIC], starting_at=moment), None)

        print(f"seek with the mcap package in the first {inside:.0f} s: {seek_times(look, inside)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=600.0, help="simulated, of the long run")
    parser.add_argument("--scene", default="hundred_bodies")
    options = parser.parse_args()
    scene = rb.load_scene(options.scene)
    bodies = len(scene.bodies)
    print(f"{options.scene}: {bodies} bodies at dt {scene.build().dt:g} s; {SHORT:g} s each:")
    with tempfile.TemporaryDirectory() as folder:
        base, last = Path(folder), 0.0
        for name, directory, rerun in (
            ("simulation alone", None, "none"),
            ("and outputs encoded", None, "off"),
            ("and the bag", base / "bag", "off"),
            ("and the Rerun view", base / "view", "file"),
        ):
            cost, counters = run(scene, SHORT, directory, rerun)
            print(f"{name:<22} {cost * 1e6:8.0f} us CPU per step  (+{(cost - last) * 1e6:.0f})")
            last = cost
        print(f"{counters['messages']} messages, {counters['dropped']} dropped")
        print(f"repeated: {verify(base / 'bag').text}")
        long, seconds = base / "long", options.seconds
        print(f"{seconds:g} s:", flush=True)
        long_run(scene, seconds, long)
        files = list(long.glob("*.mcap"))
        size = sum(path.stat().st_size for path in files)
        print(
            f"bag: {size / 1e6:.1f} MB in {len(files)} files, {size / bodies / seconds:.0f} bytes "
            "per body and second"
        )
        print_seeks(long, seconds)
        wall, cpu = time.perf_counter(), time.process_time()
        write_rrd(long, base / "long.rrd")
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        print(
            f"view from the bag: {seconds / wall:.1f} times real time, {seconds / cpu:.1f} in CPU time"
        )
        cpu = time.process_time()
        count = sum(1 for _ in Recording(long).messages())
        print(f"reading: {(time.process_time() - cpu) / count * 1e6:.1f} us CPU per message")


if __name__ == "__main__":
    main()
