"""Log lines of the Rerun view: what is told, and what contacts begin, end and strike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .geometry import BodyDescription
from .rerun_batch import Batch

_MOST = 20  # pairs of one sample that have a line each; one line tells how many more there are


class LogLines:
    """The text log; lines are sent in batches."""

    def __init__(self, recording: Any, batch: int) -> None:
        import rerun

        self._rr, self._rec = rerun, recording
        self._batch: Batch[tuple[str, str]] = Batch(batch, self._send)

    def add(self, time_ns: int, level: str, text: str) -> None:
        self._batch.add(time_ns, (level, text))

    def flush(self) -> None:
        self._batch.flush()

    def _send(self, index: Any, samples: list[tuple[str, str]]) -> None:
        levels, texts = (list(column) for column in zip(*samples, strict=True))
        columns = self._rr.TextLog.columns(text=texts, level=levels)
        self._rec.send_columns("log", indexes=[index], columns=columns)


class ContactEvents:
    """Tells where bodies come to touch and part, and what struck, as the samples show it."""

    def __init__(self, bodies: Sequence[BodyDescription], lines: LogLines) -> None:
        self._names = [body.name for body in bodies]
        self._row_of = {name: row for row, name in enumerate(self._names)}
        self._lines = lines
        self._touching: NDArray | None = None  # keys of pairs, sorted; None before any sample
        self._rows = b""  # of the bodies in the last sample: mostly they are the same again
        self._forces: dict[str, float] = {}  # N, of bodies since the last sample of contacts
        self._time = 0  # ns, of that sample

    def add_wrench(self, body: str, data: bytes) -> None:
        """The contact wrench of a body since the last sample."""
        force = math.hypot(*decoders.decode_wrench_stamped(data).values[:3])
        if force > 0.0:
            self._forces[body] = force

    def add_contacts(self, time_ns: int, points: NDArray) -> None:
        """A sample of the contacts."""
        rows = points["body_a"].tobytes() + points["body_b"].tobytes()
        before = touching = self._touching
        if touching is None or rows != self._rows:
            a, b = points["body_a"].astype(np.int64), points["body_b"].astype(np.int64)
            touching = np.unique((a << 32) | b)
        self._rows, self._touching = rows, touching
        forces, self._forces = self._forces, {}
        seconds, self._time = (time_ns - self._time) * 1e-9, time_ns
        if before is None:
            return
        if before is not touching:
            self._tell(time_ns, "touches", np.setdiff1d(touching, before, assume_unique=True))
            self._tell(time_ns, "leaves", np.setdiff1d(before, touching, assume_unique=True))
        if not forces:
            return
        pairs = np.concatenate((before, touching))
        seen = set(np.concatenate((pairs >> 32, pairs & 0xFFFFFFFF)).tolist())
        for name, force in forces.items():
            if self._row_of.get(name) not in seen:  # touched and gone between two samples
                text = f"{name} bounces: impulse {force * seconds:.3g} N s"
                self._lines.add(time_ns, "INFO", text)

    def _tell(self, time_ns: int, verb: str, pairs: NDArray) -> None:
        count = len(self._names)
        rows = [(key >> 32, key & 0xFFFFFFFF) for key in pairs.tolist()]
        known = [(self._names[a], self._names[b]) for a, b in rows if max(a, b) < count]
        for one, other in known[:_MOST]:
            self._lines.add(time_ns, "INFO", f"{one} {verb} {other}")
        if len(known) > _MOST:
            text = f"and {len(known) - _MOST} more pairs: one {verb} the other"
            self._lines.add(time_ns, "INFO", text)
