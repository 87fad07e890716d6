"""Blocks of steps of one scene, engine after engine, so that a noisy moment hits them all."""

from __future__ import annotations

import multiprocessing
import time
from dataclasses import dataclass, field

import numpy as np

from .penetration import separations
from .scene import Scene
from .scenes import scenes
from .worker import serve


class Failed(Exception):
    """The engine answered with an error, died or took too long."""


@dataclass
class Cell:
    """What one engine did in one scene."""

    engine: str
    times: list[float] = field(default_factory=list)  # s per step, of each block
    depths: list[np.ndarray] = field(default_factory=list)  # m, of contacts, after each block
    bad: str = ""  # why there is no full result
    at_least: float = 0.0  # s per step, when it was given up
    planned: int = 0  # blocks
    stands: bool | None = None
    finite: bool = True

    @property
    def seconds(self) -> float:
        """Median s per step, nan without any."""
        return float(np.median(self.times)) if self.times else float("nan")

    def depth(self, percent: float) -> float:
        """m, percentile of the penetrations of all contacts seen."""
        every = np.concatenate(self.depths) if self.depths else np.empty(0)
        return float(np.percentile(every, percent)) if every.size else 0.0

    @property
    def squared(self) -> float:
        """m², sum of squared penetrations, mean over the run."""
        return float(np.mean([np.sum(d**2) for d in self.depths])) if self.depths else float("nan")


class Worker:
    def __init__(self, name: str, core: int) -> None:
        self.name, self.core = name, core
        self.start()

    def start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, far = context.Pipe()
        self.process = context.Process(target=serve, args=(far, self.name, self.core), daemon=True)
        self.process.start()
        far.close()

    def ask(self, limit: float, *question):
        """The answer; Failed after ``limit`` seconds, with a fresh process for the next question."""
        try:
            self.pipe.send(question)
            if not self.pipe.poll(limit):
                self.stop()
                self.start()
                raise Failed(f"> {limit:.0f} s")
            error, answer = self.pipe.recv()
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self.stop()
            self.start()
            raise Failed("crashed (or out of memory)") from None
        if error:
            raise Failed(error)
        return answer

    def stop(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


def look(scene: Scene, cell: Cell, worker: Worker) -> None:
    x, q = worker.ask(60, "poses")
    cell.finite &= bool(np.isfinite(x).all() and np.isfinite(q).all())
    if not cell.finite:
        raise Failed("poses are not finite")
    cell.depths.append(np.maximum(0.0, -separations(scene, x, q)))
    if scene.tower:
        half = 0.1
        cell.stands = bool(x[:, 2].max() > scene.items[-1].position[2] - half)


def run_scene(name: str, workers: list[Worker], cap: float) -> list[Cell]:
    """Every engine has ``cap`` seconds for its steps; building is not counted."""
    scene = scenes()[name]
    cells = {worker.name: Cell(worker.name, planned=scene.blocks) for worker in workers}
    left = {}
    for worker in workers:
        cell = cells[worker.name]
        try:
            worker.ask(120, "build", name)
            left[worker.name] = cap
            # The warm-up in pieces, so that a slow engine is noticed in time.
            done, start = 0, time.perf_counter()
            while done < scene.warm_up and left[worker.name] > 0:
                piece = min(scene.warm_up - done, max(1, done))
                limit = 3 * cap
                left[worker.name] -= worker.ask(limit, "step", piece)
                done += piece
            if done < scene.warm_up or left[worker.name] <= 0:
                cell.at_least = (time.perf_counter() - start) / done
                cell.bad = (
                    f"{done} of {scene.warm_up} steps before the measurement within {cap:g} s"
                )
                look(scene, cell, worker)
                del left[worker.name]
        except Failed as error:
            left.pop(worker.name, None)
            cell.bad = str(error)
            if cell.bad.startswith(">"):
                cell.at_least = 3 * cap
    for block in range(scene.blocks):
        for worker in workers:
            cell = cells[worker.name]
            if left.get(worker.name, 0) <= 0:
                continue
            try:
                seconds = worker.ask(3 * cap, "step", scene.block)
                left[worker.name] -= seconds
                cell.times.append(seconds / scene.block)
                # Towers may fall late; the others are looked at four times.
                if block % max(1, scene.blocks // 4) == 0 or block == scene.blocks - 1:
                    look(scene, cell, worker)
            except Failed as error:
                left.pop(worker.name)
                cell.bad = str(error)
                if not cell.times and cell.bad.startswith(">"):
                    cell.at_least = 3 * cap / scene.block
    return list(cells.values())
