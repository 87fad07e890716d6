"""Real-time pacing: which step is due now, measured against absolute deadlines."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

MAX_LAG = 0.25  # s of wall time the simulation may run after before it gives the debt up
MARGIN = 1e-4  # s before a deadline in which nothing else is begun
LONGEST_SLEEP = 0.02  # s, so that commands and shutdown are seen soon with long steps
WAKE_HISTORY = 8192  # wake errors kept for the percentiles


class Pacer:
    """Step k is due at anchor + (k - first step)·dt/factor on the monotonic clock.

    Deadlines are absolute, so lateness never adds up. A thread that wakes late finds several
    steps due and runs them at once; only when it is more than `MAX_LAG` behind is the debt given
    up, and the steps that real time lost by it are counted.
    """

    def __init__(self, dt: float, factor: float) -> None:
        self._dt = dt
        self._period = 0.0
        self._anchor = 0.0
        self._first = 0
        self._counted = 0  # steps before this one were looked at for missed deadlines
        self.factor = factor
        self.missed_deadlines = 0  # steps that began a whole period or more after their deadline
        self.lost_steps = 0  # steps that real time would have made and the simulation gave up
        self._wake_errors = np.zeros(WAKE_HISTORY)
        self._wakes = 0

    def set_factor(self, factor: float) -> None:
        """Real-time factor from now on (restart to make it count); 0: as fast as possible."""
        self.factor = factor

    def restart(self, step: int) -> None:
        """Let the deadline of step `step` be now."""
        self._period = self._dt / self.factor if self.factor > 0 else 0.0
        self._anchor = time.monotonic()
        self._first = self._counted = step

    def wait(self, step: int, meanwhile: Callable[[float], None] = lambda end: None) -> int:
        """Sleep until step number `step` is due; return how many steps are (0: look again).

        `meanwhile` is called first, with the time until which it may work. With factor 0 there are
        no deadlines and the answer is always a large number.
        """
        if self._period == 0.0:
            return 1 << 30
        deadline = self._anchor + (step + 1 - self._first) * self._period
        now = time.monotonic()
        if deadline > now:
            meanwhile(deadline - MARGIN)
            now = time.monotonic()
        if deadline > now:
            time.sleep(min(deadline - now, LONGEST_SLEEP))
            now = time.monotonic()
            if now < deadline:
                return 0
        late = now - deadline
        self._wake_errors[self._wakes % WAKE_HISTORY] = late
        self._wakes += 1
        due = 1 + int(late / self._period)
        # Of the steps due, all but the last are a whole period late; each is counted once.
        self.missed_deadlines += max(0, step + due - 1 - max(step, self._counted))
        self._counted = max(self._counted, step + due - 1)
        if late > MAX_LAG + self._period:
            self.lost_steps += due - 1
            self.restart(step)
            return 1
        return due

    def wake_error_percentiles(self) -> tuple[float, float]:
        """Median and 99th percentile of the lateness of the last wakes, s (0, 0 before any)."""
        kept = self._wake_errors[: min(self._wakes, WAKE_HISTORY)]
        if len(kept) == 0:
            return 0.0, 0.0
        p50, p99 = np.percentile(kept, (50, 99))
        return float(p50), float(p99)
