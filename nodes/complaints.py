"""Warnings about refused messages: the first at once, then at most one a second for each topic."""

from __future__ import annotations

import time
from collections.abc import Callable

INTERVAL = 1.0  # s of wall time


class Complaints:
    """Throttles by key; says how many lines were left out."""

    def __init__(self, warn: Callable[[str], object]) -> None:
        self._warn = warn
        self._next: dict[str, float] = {}
        self._left_out: dict[str, int] = {}

    def __call__(self, key: str, text: str) -> None:
        now = time.monotonic()
        if now < self._next.get(key, now):
            self._left_out[key] = self._left_out.get(key, 0) + 1
            return
        self._next[key] = now + INTERVAL
        left_out = self._left_out.pop(key, 0)
        self._warn(f"{text} ({left_out} refused since the last line)" if left_out else text)
