"""How far a long computation has come, for people: a bar or lines on standard error."""

from __future__ import annotations

import sys
import time
from typing import Any, TextIO

LINE_EVERY = 5.0  # s of wall time between progress lines where there is no terminal


class Progress:
    """A progress bar on a terminal, a line every few seconds elsewhere; counts steps."""

    def __init__(self, steps: int, dt: float, stream: TextIO = sys.stderr) -> None:
        self.steps, self.dt, self.stream = steps, dt, stream
        self.done = 0
        self.next_line = time.monotonic() + LINE_EVERY
        self.bar: Any = None
        self.pending, self.shown = 0, time.monotonic()

    def __enter__(self) -> Progress:
        if self.stream.isatty():
            from tqdm import tqdm

            self.bar = tqdm(
                total=self.steps * self.dt,
                file=self.stream,
                unit="s",
                bar_format="{percentage:3.0f}% |{bar}| {n:.1f}/{total:.1f} s simulated, {remaining} left",
            )
        return self

    def __call__(self, count: int) -> None:
        self.done += count
        self.pending += count
        now = time.monotonic()
        if self.bar is not None:
            if now - self.shown > 0.1 or self.done == self.steps:
                self.bar.update(self.pending * self.dt)
                self.pending, self.shown = 0, now
        elif now >= self.next_line:
            self.next_line = now + LINE_EVERY
            print(
                f"{self.done * self.dt:.1f} of {self.steps * self.dt:.1f} s simulated",
                file=self.stream,
                flush=True,
            )

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()


class LateProgress:
    """Progress of something whose length is known when it reports for the first time."""

    def __init__(self) -> None:
        self.bar: Progress | None = None

    def __enter__(self) -> LateProgress:
        return self

    def __call__(self, done: int, total: int, dt: float) -> None:
        if self.bar is None:
            self.bar = Progress(total, dt).__enter__()
        self.bar(done - self.bar.done)

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.__exit__()
