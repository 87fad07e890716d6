"""Repeating a run from its log: the scene is built again, every logged change of the world is done
again before the same step, and the state hash of each step is compared.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergedError
from . import decoders
from .environment import environment
from .log_reader import Recording, damage_told
from .mcap_log import RecordingError
from .operations import CHANGE_BODIES, Operation, Operations
from .operations import from_json as operation_from_json
from .recorder import FORMAT_VERSION

if TYPE_CHECKING:
    from ..scene import Scene

_QUANTITIES = ("position", "orientation", "linear_velocity", "angular_velocity")
_REPEATABLE = 2  # the oldest format version with today's state hash
_AT_ONCE = 256  # steps between two looks at the hashes


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


class Run:
    """What is needed to repeat a recorded run. Raises RecordingError when something is missing."""

    def __init__(self, recording: str | Path) -> None:
        self.log = log = Recording(recording)
        self.notes = notes = log.custom_data
        _require_repeatable(log, notes)
        attachments = log.attachments()
        if "scene.yaml" not in attachments:
            raise RecordingError(
                f"{log.directory} holds no scene: it was recorded from a world built by a program, "
                "and only that program can repeat it"
            )
        self.scene_text = attachments["scene.yaml"].decode("utf-8", "replace")
        self.operations: list[Operation] = []
        self.snapshots: dict[int, bytes] = {}
        with damage_told(log):
            self.settings: dict[str, Any] = dict(json.loads(notes["settings"]))
            self.dt = float(notes["dt"])  # s
            if not 0.0 < self.dt < math.inf:
                raise ValueError(f"dt is {self.dt}")
            self.first_step = int(notes["first_step"])  # steps of log time before the start
            self._namespace = "/" + notes["node_name"].strip("/") + "/"
            self.steps, self.hashes = self._read()
        if len(self.steps) == 0 and self.recorded_steps != 0:
            raise RecordingError(
                f"{log.directory} holds no state hashes: there is nothing to compare a repetition with"
            )
        if not np.array_equal(self.steps, np.arange(1, len(self.steps) + 1)):
            raise RecordingError(f"{log.directory}: the state hashes of some steps are missing")
        self.initial = attachments.get("initial.snapshot", self.snapshots.get(0, b""))
        if 0 not in self.snapshots:
            raise RecordingError(f"{log.directory}: the snapshot of the start is missing")

    @property
    def recorded_steps(self) -> int | None:
        """Steps that were made, as noted at the end; None where the end is missing."""
        noted = self.notes.get("steps", "")
        return int(noted) if noted.isdecimal() else None

    def _read(self) -> tuple[NDArray, NDArray]:
        """Operations and snapshots into place; the steps with a hash, and the hashes."""
        rows = [np.empty((0, 2), np.uint64)]
        names = {self._namespace + n: n for n in ("state_hash", "operations", "snapshots")}
        for message in self.log.messages(set(names)):
            kind = names[message.topic]
            if kind == "state_hash":
                rows.append(decoders.decode_multi_array(message.data, "u8")[1].reshape(-1, 2))
            elif kind == "operations":
                self.operations.append(operation_from_json(decoders.decode_string(message.data)))
            else:
                (label,), data = decoders.decode_multi_array(message.data, "u1")
                self.snapshots[int(label.removeprefix("step "))] = data.tobytes()
        table = np.concatenate(rows)
        return table[:, 0].astype(np.int64), table[:, 1]

    @cached_property
    def poses(self) -> dict[int, NDArray]:
        """Logged poses (N, 7) by step; read when first asked for, they are most of a log."""
        with damage_told(self.log):
            return {
                message.step: decoders.decode_pose_array(message.data)[2]
                for message in self.log.messages({self._namespace + "poses"})
            }

    def scene(self) -> Scene:
        """The recorded scene."""
        from ..scene import Scene

        source = f"{self.log.directory}/scene.yaml"
        return Scene.from_yaml(self.scene_text, name=self.notes.get("scene", ""), source=source)

    def build(self, **settings: Any) -> Any:
        """A new world at the start of the run; `settings` replace recorded ones (threads, ...)."""
        world = self.scene().build(**(self.settings | settings))
        _restore(world, self, 0)
        return world


def _require_repeatable(log: Recording, notes: dict[str, str]) -> None:
    version = notes.get("format_version")
    if version is None:
        what = "is empty or damaged at its start" if log.torn else "was not made by rb_physics"
        raise RecordingError(f"{log.directory} {what}")
    if not version.isdecimal() or int(version) > FORMAT_VERSION:
        raise RecordingError(
            f"{log.directory} has format version {version}; this rb_physics reads up to "
            f"{FORMAT_VERSION}: install a newer one"
        )
    if int(version) < _REPEATABLE:
        raise RecordingError(
            f"{log.directory} has format version {version}, whose state hashes this rb_physics no "
            "longer computes: it can be viewed, exported and compared, but repeated only by the "
            "version that made it"
        )


def _restore(world: Any, run: Run, step: int) -> None:
    try:
        world.restore(run.snapshots[step])
    except ValueError as error:
        raise RecordingError(
            f"{run.log.directory}: the snapshot of step {step} doesn't fit: {error}"
        ) from None


class Repetition:
    """Repeats a run step by step. `step` counts as in the recording."""

    def __init__(self, run: Run, **settings: Any) -> None:
        self._run = run
        self.world = run.build(**settings)
        self._operations = Operations(self.world, run.initial)
        self._pending = list(reversed(run.operations))
        self.diverged: DivergedError | None = None  # why it can't go on
        self.step = 0

    def skip_to(self, step: int) -> None:
        """Jumps to a snapshot; bodies come and go as they did before it."""
        while self._pending and self._pending[-1].step < step:
            operation = self._pending.pop()
            if operation.name in (*CHANGE_BODIES, "change_body"):  # surfaces aren't in snapshots
                self._perform(operation)
        _restore(self.world, self._run, step)
        self.step = step

    def pending(self) -> list[Operation]:
        """The logged changes that are still to come, the next one last."""
        return list(self._pending)

    @property
    def added(self) -> dict[str, dict[str, Any]]:
        """Descriptions of the bodies added since the start, by name in their order."""
        return self._operations.descriptions

    def _perform(self, operation: Operation) -> None:
        try:
            self._operations.perform(operation.name, operation.arguments)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise RecordingError(
                f"{self._run.log.directory}: {operation.name} at step {operation.step} can't be "
                f"done again: {error}"
            ) from None

    def advance(self, until: int) -> NDArray:
        """Steps to `until`, at most to the next logged change after the present one; the hashes."""
        while self._pending and self._pending[-1].step <= self.step:
            self._perform(self._pending.pop())
        if self._pending:
            until = min(until, self._pending[-1].step)
        self.world.keep_hashes = True
        self.world.drain_hashes()
        try:
            self.world.step(until - self.step)
        except DivergedError as error:
            self.diverged = error
        except ValueError as error:
            raise RecordingError(
                f"{self._run.log.directory}: what is recorded up to step {self.step} can't go on: {error}"
            ) from None
        hashes = np.asarray(self.world.drain_hashes(), np.uint64)
        self.step = until if self.diverged is None else self.step + len(hashes)
        return hashes


def verify(
    recording: str | Path,
    *,
    start: float | None = None,
    progress: Callable[[int, int, float], None] | None = None,
    **settings: Any,
) -> Verification:
    """Repeats a recording and compares the state hash of every step.

    Args:
        start: s of log time; begins at the last snapshot not after it instead of the start.
        progress: called with (steps done, steps in all, s per step).
        settings: replace recorded ones; those that must not matter, such as threads.

    Raises RecordingError.
    """
    run = Run(recording)
    dt = run.dt
    repetition = Repetition(run, **settings)
    if start is not None:
        begin, end = run.first_step * dt, (run.first_step + len(run.hashes)) * dt
        if not begin - dt / 2 <= start <= end + dt / 2:
            raise RecordingError(
                f"start is {start:g} s; {run.log.directory} goes from {begin:g} to {end:g} s"
            )
        repetition.skip_to(
            max(s for s in run.snapshots if s == 0 or (s + run.first_step) * dt <= start + dt / 2)
        )
    first = repetition.step
    last = len(run.hashes)
    while repetition.step < last:
        before = repetition.step
        hashes = repetition.advance(min(before + _AT_ONCE, last))
        wrong = np.nonzero(hashes != run.hashes[before : before + len(hashes)])[0]
        if len(wrong):
            step = before + int(wrong[0]) + 1
            difference = _locate(run, step, first, settings)._replace(done=_done(run, step))
            return Verification(
                step - 1 - first, (step - 1 - first) * dt, difference, _remarks(run)
            )
        if repetition.diverged is not None:
            step = repetition.step + 1
            difference = _divergence(repetition, step)._replace(done=_done(run, step))
            return Verification(
                step - 1 - first, (step - 1 - first) * dt, difference, _remarks(run)
            )
        if progress is not None:
            progress(repetition.step - first, last - first, dt)
    steps = repetition.step - first
    return Verification(steps, steps * dt, None, _remarks(run))


def _locate(run: Run, step: int, first: int, settings: dict[str, Any]) -> Difference:
    """The first body and quantity that differ in what was logged from `step` on."""
    logged = sorted({s for s in run.poses if s >= step} | {s for s in run.snapshots if s >= step})
    repetition = Repetition(run, **settings)
    if first:
        repetition.skip_to(first)
    other = Repetition(run, **settings)
    for seen in logged:
        while repetition.step < seen:
            repetition.advance(seen)
            if repetition.diverged is not None:
                return _divergence(repetition, step)
        names = [body.name for body in repetition.world.bodies]
        if seen in run.snapshots:
            other.skip_to(seen)
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
    elif run.log.torn:
        lost = [f"torn off: the recording holds {held} steps"]
    return (
        *lost,
        *(
            f"recorded with {key} {run.notes[key]}, repeated with {value}"
            for key, value in here.items()
            if key in run.notes and run.notes[key] != value
        ),
    )
