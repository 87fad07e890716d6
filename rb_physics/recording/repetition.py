"""A recorded run done again, step by step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DivergedError
from .errors import RecordingError
from .operations import CHANGE_BODIES, Operation, Operations
from .recorded_run import Run


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
        """Jumps ahead to a snapshot; bodies come and go as they did before it.

        Where inputs are lost some may be impossible without those: the snapshot then tells whether
        it fits. Raises RecordingError when it doesn't.
        """
        while self._pending and self._pending[-1].step < step:
            operation = self._pending.pop()
            if operation.name in (*CHANGE_BODIES, "change_body"):  # surfaces aren't in snapshots
                try:
                    self._perform(operation)
                except RecordingError:
                    if not self._run.lost:
                        raise
        self._run.restore(self.world, step)
        self.step = step
        self.diverged = None

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
