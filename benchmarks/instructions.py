"""Instructions per step of five key scenes, counted by callgrind: a slowdown shows on a noisy machine.

``python -m benchmarks.instructions`` compares with ``instructions.json`` and fails when a scene takes
more than 5 % above it; ``--write`` takes the present counts for the new ones. Counts depend on the
compiler: with another one than that of the file they are shown, not judged.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from rb_physics import _core

from .engines import scenes

ROOT = Path(__file__).resolve().parents[1]
COUNTS = Path(__file__).with_name("instructions.json")
MOST = 1.05  # callgrind repeats to 1e-4; a memcpy of another length is below this
# Scene, steps before the count, steps counted.
SCENES = {
    "one resting box": (scenes.single, 20, 50),
    "100 resting boxes": (lambda: scenes.resting(100), 20, 10),
    "tower of 10": (lambda: scenes.tower(10), 100, 50),
    "100 bouncing boxes": (lambda: scenes.separate(100), 120, 4),
    "pile of 40 boxes": (lambda: scenes.pile(40), 2, 2),
}


def play(name: str, steps: int) -> None:
    from .engines.engine_rb_physics import RbPhysics

    scene, warm_up, _ = SCENES[name]
    RbPhysics(scene()).step(warm_up + steps)


def counted(name: str, steps: int) -> int:
    """Instructions inside `step` of a run of the warm-up and that many steps."""
    with tempfile.TemporaryDirectory() as folder:
        # -S: site files may start the interpreter again, outside of valgrind.
        done = subprocess.run(
            [
                "valgrind",
                "--tool=callgrind",
                "--toggle-collect=rb::step(rb::World&)",
                f"--callgrind-out-file={folder}/out",
                sys.executable,
                "-S",
                "-m",
                "benchmarks.instructions",
                "--play",
                name,
                str(steps),
            ],
            capture_output=True,
            text=True,
            cwd=ROOT,
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join(
                    [str(ROOT), str(Path(np.__file__).resolve().parents[1])]
                ),
            },
            timeout=600,
        )
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found or found[1] == "0":
        raise RuntimeError(f"callgrind counted nothing in {name}: {done.stderr[-500:]}")
    return int(found[1])


def per_step(name: str) -> int:
    steps = SCENES[name][2]
    return round((counted(name, steps) - counted(name, 0)) / steps)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.instructions", description=__doc__)
    parser.add_argument("--write", action="store_true", help="take the counts for the new ones")
    parser.add_argument("--play", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.play:
        play(arguments.play[0], int(arguments.play[1]))
        return 0
    if shutil.which("valgrind") is None:
        print("instructions: skipped, valgrind is not installed")
        return 0
    known = json.loads(COUNTS.read_text()) if COUNTS.exists() else {"compiler": "", "counts": {}}
    same = known["compiler"] == _core.compiler
    counts = {}
    slower = []
    print(f"{'scene':24s} {'instructions per step':>22s} {'known':>12s} {'ratio':>7s}")
    for name in SCENES:
        counts[name] = per_step(name)
        before = known["counts"].get(name)
        ratio = counts[name] / before if before else float("nan")
        print(f"{name:24s} {counts[name]:22,d} {before or 0:12,d} {ratio:7.3f}", flush=True)
        if ratio > MOST:
            slower.append(name)
    if arguments.write:
        text = json.dumps({"compiler": _core.compiler, "counts": counts}, indent=2)
        COUNTS.write_text(text + "\n")
        return 0
    if not same:
        print(f"counted with {_core.compiler}, known from {known['compiler']}: not judged")
        return 0
    if slower:
        print(f"slower than before: {', '.join(slower)}; faster for a reason? then --write")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
