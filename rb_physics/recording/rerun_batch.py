"""Samples gathered until there are enough to be sent to Rerun as columns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

Sample = TypeVar("Sample")
LIVE = 25  # samples sent at once while a run goes on: a quarter of a second
AFTERWARDS = 400  # from a finished recording: sending costs by the call


class Batch(Generic[Sample]):
    """One kind of sample; `send(index, samples)` takes what was gathered, index being its times."""

    def __init__(self, size: int, send: Callable[[Any, list[Sample]], None]) -> None:
        self._size, self._send = size, send
        self._times: list[int] = []
        self._samples: list[Sample] = []

    def add(self, time_ns: int, sample: Sample) -> None:
        self._times.append(time_ns)
        self._samples.append(sample)
        if len(self._times) >= self._size:
            self.flush()

    def flush(self) -> None:
        if not self._times:
            return
        times, samples = self._times, self._samples
        self._times, self._samples = [], []
        self._send(time_index(times), samples)


def time_index(times: list[int]) -> Any:
    """Rerun's column of times (ns)."""
    import rerun

    stamps = np.array(times, np.int64).astype("timedelta64[ns]")
    return rerun.TimeColumn("sim_time", duration=stamps)
