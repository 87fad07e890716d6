"""Repeating a run from its log: the scene is built again, every logged change of the world is done
again before the same step, and the state hash of each step is compared.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .environment import environment
from .errors import RecordingError
from .lost_spans import LostSpan
from .recorded_run import Run
from .repetition import Repetition

_QUANTITIES = ("position", "orientation", "linear_velocity", "angular_velocity")
_AT_ONCE = 256  # steps between two looks at the hashes
_BRIDGE = 100_000  # steps without a hash that are simulated to compare what follows them


class Difference(NamedTuple):
    """Where a repetition left the recording."""

    step: int  # first step whose hash differs
    seen_step: int  # step at which the quantity was compared, the first logged one from there on
    body: str
    quantity: str
    recorded: str
    repeated: str
    done: tuple[str, ...] = ()  # logged changes of the world right before that step


class Verification(NamedTuple):
    """The outcome of `verify`."""

    steps: int  # steps compared and equal
    duration: float  # s of simulated time they cover
    difference: Difference | None
    remarks: tuple[str, ...]  # what is lost; differences of version and machine

    @property
    def text(self) -> str:
        """For people."""
        lines = list(self.remarks)
        d = self.difference
        if d is None:
            lines.append(f"identical, {self.steps} steps, {self.duration:g} s")
        else:
            lines.append(f"differs from step {d.step} on, after {self.steps} identical steps")
            if d.body:
                lines.append(
                    f"at step {d.seen_step}, body {d.body}: {d.quantity} recorded {d.recorded}, "
                    f"repeated {d.repeated}"
                )
            else:
                lines.append(d.quantity)
            if d.done:
                lines.append(f"done right before step {d.step}: {', '.join(d.done)}")
        return "\n".join(lines)


class _Comparison:
    """A repetition under way, with what it has found to be as recorded.

    Where something is lost the repetition goes on with what there is. If the next hash is another
    then, inputs are lost, too, and it begins anew at the next snapshot behind.
    """

    def __init__(self, run: Run, settings: dict[str, Any], start: float | None) -> None:
        self.run, self._settings = run, settings
        self.repetition = Repetition(run, **settings)
        self.origin = 0  # where it began last
        if start is not None:
            self.origin = _snapshot_before(run, start)
            if self.origin > 0:
                self.repetition.skip_to(self.origin)
        self.first = self._equal = self.origin  # _equal: up to here it is as recorded
        self.steps = 0  # compared and equal
        self.lost: list[tuple[int, int, bool]] = []  # spans, and whether inputs are lost with them

    def advance(self) -> Difference | None:
        """Some steps; what differs from the recording for no loss."""
        run, before = self.run, self.repetition.step
        try:
            self._bridge(before)
            hashes = self.repetition.advance(min(before + _AT_ONCE, run.last_step))
        except RecordingError:
            if not self._anew(before + 1):
                raise
            return None
        reached = before + len(hashes)
        wrong = run.first_difference(before, hashes)
        good = run.compared(before, reached if wrong is None else wrong - 1)
        if good.stop > good.start:
            self.steps += good.stop - good.start
            self._equal = int(run.steps[good.stop - 1])
        if wrong is None and self.repetition.diverged is None:
            return None
        step = wrong if wrong is not None else reached + 1
        if self._anew(step):
            return None
        if wrong is None:
            return _divergence(self.repetition, step)
        return _locate(run, step, self.origin, self._settings)

    def _bridge(self, step: int) -> None:
        """Raises RecordingError where the next hash is too far to get there."""
        ahead = self.run.compared(step, self.run.last_step).start
        if ahead < len(self.run.steps) and self.run.steps[ahead] - step > _BRIDGE:
            raise RecordingError(
                f"{self.run.log.directory}: the state hashes of {self.run.steps[ahead] - step} steps "
                f"behind step {step} are missing"
            )

    def _anew(self, step: int) -> bool:
        """Goes on at a snapshot if a loss may be why `step` is not as recorded."""
        spans = [
            span
            for span in self.run.lost
            if span.after < step and self._end(span) >= max(self._equal, self.origin)
            and not span.after < self._end(span) <= self.origin
        ]  # fmt: skip
        if not spans:
            return False
        behind = max(step, *(self._end(span) for span in spans))
        for snapshot in sorted(s for s in self.run.snapshots if s >= behind):
            try:
                self.repetition.skip_to(snapshot)
            except RecordingError:  # bodies came or went in what is lost
                continue
            self.lost.append((self._equal, snapshot, True))
            self.origin = self._equal = snapshot
            return True
        self.lost.append((self._equal, self.run.last_step, True))
        self.repetition.step = self._equal = self.run.last_step  # the end
        return True

    @staticmethod
    def _end(span: LostSpan) -> int:
        return span.after if span.before is None else span.before

    def remarks(self) -> list[str]:
        """What is lost, for people."""
        run, told = self.run, []
        spans = [(s.after, self._end(s), False) for s in run.lost if self._end(s) > self.first]
        inside = [s for s in spans if not any(a <= s[0] and s[1] <= b for a, b, _ in self.lost)]
        for after, before, inputs in sorted(inside + self.lost):
            if after >= max(self._equal, self.repetition.step) and not inputs:
                continue  # not reached
            times = " to ".join(f"{(run.first_step + step) * run.dt:g}" for step in (after, before))
            if not inputs:
                what = "the state behind it is the recorded one"
            elif before == run.last_step and before not in run.snapshots:
                what = "inputs are missing, too, and no snapshot is left to begin anew at"
            else:
                what = f"inputs are missing, too: compared again from the snapshot at {times.split()[-1]} s on"
            told.append(f"lost from {times} s: {what}")
        return told


def verify(
    recording: str | Path,
    *,
    start: float | None = None,
    progress: Callable[[int, int, float], None] | None = None,
    **settings: Any,
) -> Verification:
    """Repeats a recording and compares the state hash of every step that has one.

    Args:
        start: s of log time; begins at the last snapshot not after it instead of the start.
        progress: called with (steps done, steps in all, s per step).
        settings: replace recorded ones; those that must not matter, such as threads.

    Raises RecordingError.
    """
    run = Run(recording)
    comparison = _Comparison(run, settings, start)
    first, last = comparison.first, run.last_step
    difference = None
    while difference is None and comparison.repetition.step < last:
        difference = comparison.advance()
        if progress is not None and difference is None:
            progress(comparison.repetition.step - first, last - first, run.dt)
    if comparison.steps == 0 and difference is None and last > first:
        raise RecordingError(
            f"{run.log.directory}: too much is lost, nothing can be compared with a repetition"
        )
    if difference is not None:
        difference = difference._replace(done=_done(run, difference.step))
    remarks = (*comparison.remarks(), *_remarks(run))
    return Verification(comparison.steps, comparison.steps * run.dt, difference, remarks)


def _snapshot_before(run: Run, start: float) -> int:
    """The step of the last snapshot not after `start`, s of log time. Raises RecordingError."""
    dt = run.dt
    begin, end = run.first_step * dt, (run.first_step + run.last_step) * dt
    if not begin - dt / 2 <= start <= end + dt / 2:
        raise RecordingError(
            f"start is {start:g} s; {run.log.directory} goes from {begin:g} to {end:g} s"
        )
    return max([0, *(s for s in run.snapshots if (s + run.first_step) * dt <= start + dt / 2)])


def _locate(run: Run, step: int, first: int, settings: dict[str, Any]) -> Difference:
    """The first body and quantity that differ in what was logged from `step` on."""
    logged = sorted({s for s in run.poses if s >= step} | {s for s in run.snapshots if s >= step})
    repetition = Repetition(run, **settings)
    if first:
        repetition.skip_to(first)
    other = Repetition(run, **settings)
    for seen in logged:
        try:
            while repetition.step < seen:
                repetition.advance(seen)
                if repetition.diverged is not None:
                    return _divergence(repetition, step)
            if seen in run.snapshots:
                other.skip_to(seen)
        except RecordingError:  # by what is lost
            break
        names = [body.name for body in repetition.world.bodies]
        if seen in run.snapshots:
            for quantity in _QUANTITIES:
                rows = getattr(other.world, _plural(quantity))
                found = _widest(rows, getattr(repetition.world, _plural(quantity)))
                if found is not None:
                    row, a, b = found
                    return Difference(step, seen, names[row], quantity, a, b)
        elif len(run.poses[seen]) == len(names):
            for quantity, columns in (("position", slice(0, 3)), ("orientation", slice(3, 7))):
                found = _widest(
                    run.poses[seen][:, columns], getattr(repetition.world, _plural(quantity))
                )
                if found is not None:
                    row, a, b = found
                    return Difference(step, seen, names[row], quantity, a, b)
    return Difference(
        step, step, "", "no logged pose differs: the difference is in velocities, contact forces or "
        "applied wrenches between two logged states", "", "",
    )  # fmt: skip


def _divergence(repetition: Repetition, step: int) -> Difference:
    error = repetition.diverged
    assert error is not None
    return Difference(step, repetition.step + 1, error.body, "state", "finite", "not finite")


def _done(run: Run, step: int) -> tuple[str, ...]:
    """What was done to the world between step - 1 and step."""
    return tuple(
        " ".join([o.name, *([str(o.arguments["body"])] if "body" in o.arguments else [])])
        for o in run.operations
        if o.step == step - 1
    )


def _plural(quantity: str) -> str:
    return quantity.replace("velocity", "velocities") if "velocity" in quantity else quantity + "s"


def _widest(recorded: NDArray, repeated: NDArray) -> tuple[int, str, str] | None:
    """The row that differs most: what was pushed moves more than what it pushes in turn."""
    if np.array_equal(recorded, repeated):
        return None
    row = int(np.argmax(np.max(np.abs(recorded - repeated), axis=1)))
    return row, str(recorded[row].tolist()), str(repeated[row].tolist())


def _remarks(run: Run) -> tuple[str, ...]:
    """What the recording has lost, and what is different here from where it was made."""
    here, held = environment(), len(run.hashes)
    lost = []
    if run.recorded_steps not in (None, held):
        lost = [f"{run.recorded_steps} steps were made, the recording holds {held} of them"]
    elif run.log.torn or (run.recorded_steps is None and "recovered_from" in run.notes):
        lost = [f"torn off: the recording holds {held} steps"]
    return (
        *lost,
        *(
            f"recorded with {key} {run.notes[key]}, repeated with {value}"
            for key, value in here.items()
            if key in run.notes and run.notes[key] != value
        ),
    )
