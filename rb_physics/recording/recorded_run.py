"""What a recording holds of a run, so far as repeating it needs that."""

from __future__ import annotations

import json
import math
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .errors import RecordingError
from .log_reader import Recording, damage_told
from .lost_spans import LostSpan, merged
from .lost_spans import from_json as lost_from_json
from .operations import Operation
from .operations import from_json as operation_from_json
from .recorder import FORMAT_VERSION

if TYPE_CHECKING:
    from ..scene import Scene

_REPEATABLE = 2  # the oldest format version with today's state hash


class Run:
    """What is needed to repeat a recorded run. Raises RecordingError when something is missing."""

    def __init__(self, recording: str | Path) -> None:
        self.log = log = Recording(recording)
        self.notes = notes = log.custom_data
        _require_repeatable(log, notes)
        self.scene_text = log.attachment(
            "scene.yaml",
            "holds no scene: it was recorded from a world built by a program, and only that program "
            "can repeat it",
        ).decode("utf-8", "replace")
        self._initial = log.attachments().get("initial.snapshot")
        if "initial.snapshot" in log.damaged_attachments:
            log.attachment("initial.snapshot", "has none")
        self.operations: list[Operation] = []
        self.snapshots: dict[int, bytes] = {}
        with damage_told(log):
            self.settings: dict[str, Any] = dict(json.loads(notes["settings"]))
            self.dt = float(notes["dt"])  # s
            if not 0.0 < self.dt < math.inf:
                raise ValueError(f"dt is {self.dt}")
            self.first_step = int(notes["first_step"])  # steps of log time before the start
            self._namespace = "/" + notes["node_name"].strip("/") + "/"
            self.steps, self.hashes = self._read()  # steps with a hash, in order, and the hashes
            self.lost = self._lost()
        if len(self.steps) == 0 and self.recorded_steps != 0:
            raise RecordingError(
                f"{log.directory} holds no state hashes: there is nothing to compare a repetition with"
            )
        if len(self.steps) and (self.steps[0] < 1 or (np.diff(self.steps) < 1).any()):
            raise RecordingError(f"{log.directory}: the state hashes are not in the order of steps")
        if self._initial is None:
            self._initial = self.snapshots.get(0)

    def _lost(self) -> list[LostSpan]:
        """Between which steps inputs may be missing: where state hashes are, what the reader passed
        over, and what was passed over when the recording was recovered."""
        steps = np.concatenate([[0], self.steps])
        holes = np.nonzero(np.diff(steps) > 1)[0]
        spans = [LostSpan(int(steps[i]), int(steps[i + 1])) for i in holes]
        if 0 not in self.snapshots:
            spans.append(LostSpan(0, 0))
        return merged([*spans, *self.log.lost, *lost_from_json(self.notes.get("lost_steps", "[]"))])

    @property
    def last_step(self) -> int:
        """The last step with a hash."""
        return int(self.steps[-1]) if len(self.steps) else 0

    @cached_property
    def initial(self) -> bytes:
        """The snapshot that `reset` goes back to; where it is lost, the scene as it is built."""
        if self._initial is not None:
            return self._initial
        state: bytes = self.build().save()
        return state

    def first_difference(self, step: int, hashes: NDArray) -> int | None:
        """The first of the steps behind `step` whose hash is another than the recorded one; steps
        without a recorded hash are passed over."""
        known = self.compared(step, step + len(hashes))
        wrong = np.nonzero(hashes[self.steps[known] - step - 1] != self.hashes[known])[0]
        return int(self.steps[known][wrong[0]]) if len(wrong) else None

    def compared(self, after: int, until: int) -> slice:
        """The rows of `steps` and `hashes` in (after, until]."""
        first, last = np.searchsorted(self.steps, (after, until), side="right")
        return slice(int(first), int(last))

    @property
    def recorded_steps(self) -> int | None:
        """Steps that were made, as noted at the end; None where the end is missing."""
        noted = self.notes.get("steps", "")
        return int(noted) if noted.isdecimal() else None

    def _read(self) -> tuple[NDArray, NDArray]:
        """Operations and snapshots into place; the steps with a hash, and the hashes."""
        rows = [np.empty((0, 2), np.uint64)]
        names = {self._namespace + n: n for n in ("state_hash", "operations", "snapshots")}
        for message in self.log.messages(set(names), skip_damaged=True):
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
                for message in self.log.messages({self._namespace + "poses"}, skip_damaged=True)
            }

    def scene(self) -> Scene:
        """The recorded scene."""
        from ..scene import Scene

        source = f"{self.log.directory}/scene.yaml"
        return Scene.from_yaml(self.scene_text, name=self.notes.get("scene", ""), source=source)

    def build(self, **settings: Any) -> Any:
        """A new world at the start of the run; `settings` replace recorded ones (threads, ...)."""
        world = self.scene().build(**(self.settings | settings))
        if 0 in self.snapshots:
            self.restore(world, 0)
        else:
            world.step_count = self.first_step
        return world

    def restore(self, world: Any, step: int) -> None:
        """The state of the snapshot of `step`. Raises RecordingError."""
        try:
            world.restore(self.snapshots[step])
        except ValueError as error:
            raise RecordingError(
                f"{self.log.directory}: the snapshot of step {step} doesn't fit: {error}"
            ) from None


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
