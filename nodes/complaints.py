"""Warnings about refused messages: each text at once, then at most once a second for its topic."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

INTERVAL = 1.0  # s of wall time
LONGEST = 1000  # characters of a line; names and texts come from other nodes
MOST_TEXTS = 10  # of one topic within the interval: a flood of wrong names is cut there


@dataclass
class _Window:
    end: float
    texts: set[str] = field(default_factory=set)
    left_out: int = 0


def printable(text: str) -> str:
    """One line of bounded length, control characters as their escapes: what others send can't break
    or forge lines of the log."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    return line if len(line) <= LONGEST else f"{line[:LONGEST]}… ({len(line)} characters)"


class Complaints:
    """Throttles by key and text; says how many lines were left out."""

    def __init__(self, warn: Callable[[str], object]) -> None:
        self._warn = warn
        self._windows: dict[str, _Window] = {}

    def __call__(self, key: str, text: str) -> None:
        text = printable(text)
        now = time.monotonic()
        window = self._windows.get(key)
        if window is None or now >= window.end:
            left_out = window.left_out if window else 0
            window = self._windows[key] = _Window(now + INTERVAL)
            window.texts.add(text)
            self._warn(f"{text} ({left_out} refused since the last line)" if left_out else text)
        elif text in window.texts or len(window.texts) >= MOST_TEXTS:
            window.left_out += 1
        else:
            window.texts.add(text)
            self._warn(text)
