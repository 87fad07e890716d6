"""``python -m benchmarks.engines``: the table, RESULTS.md and the plot beside it."""

from __future__ import annotations

import argparse
import fnmatch
import os
import sys
import time
from pathlib import Path

from .report import HEADER, document, rows
from .runner import Cell, Failed, Worker, run_scene
from .scenes import scenes
from .worker import ENGINES

FOLDER = Path(__file__).resolve().parents[1]


def chosen(names, patterns: list[str], what: str) -> list[str]:
    found = [n for n in names if any(fnmatch.fnmatch(n.lower(), p.lower()) for p in patterns)]
    if not found:
        sys.exit(f"no {what} matches {' '.join(patterns)}; there are: {', '.join(names)}")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.engines", description=__doc__)
    parser.add_argument("--scenes", nargs="+", default=["*"], metavar="PATTERN")
    parser.add_argument("--engines", nargs="+", default=["*"], metavar="PATTERN")
    parser.add_argument("--cap", type=float, default=4.0, help="s per engine and scene (4)")
    parser.add_argument("--core", type=int, help="pin everything to this core (the last allowed)")
    parser.add_argument("--no-write", action="store_true", help="print only")
    arguments = parser.parse_args()
    core = arguments.core if arguments.core is not None else max(os.sched_getaffinity(0))
    names = chosen(scenes(), arguments.scenes, "scene")
    workers, labels, missing = [], {}, {}
    for name in chosen(ENGINES, arguments.engines, "engine"):
        worker = Worker(name, core)
        try:
            precision, version = worker.ask(120, "version")
            labels[name] = f"{version} | {precision}"
            workers.append(worker)
        except Failed as error:
            missing[name] = str(error)
            worker.stop()
            print(f"{name} is left out: {error}", file=sys.stderr)
    start = time.perf_counter()
    results: dict[str, list[Cell]] = {}
    print("\n".join(HEADER), flush=True)
    for name in names:
        results[name] = run_scene(name, workers, arguments.cap)
        print("\n".join(rows(name, results[name], {})), flush=True)
    for worker in workers:
        worker.stop()
    print(f"{time.perf_counter() - start:.0f} s", file=sys.stderr)
    if arguments.no_write:
        return
    from .front import draw

    (FOLDER / "RESULTS.md").write_text(
        document(results, labels, missing, arguments.cap), encoding="utf-8"
    )
    draw(results, FOLDER / "results.png")


if __name__ == "__main__":
    main()
