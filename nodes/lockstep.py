"""Lockstep: a step is made when every wrench source has sent the message for it."""

from __future__ import annotations

import time
from collections.abc import Iterable

from .refused import WrongStampError

PATIENCE = 2.0  # s of wall time after which it is said for whom a step waits


class Lockstep:
    """Which sources have delivered for the next step.

    The message for a step is the one whose header.stamp equals the step's start time; every other
    one is refused, and so is a second one of the same source, so that what acts never depends on
    the order of arrival.
    """

    def __init__(self) -> None:
        self._awaited: set[str] = set()
        self._delivered: set[str] = set()
        self._since: float | None = None  # wall time at which waiting began
        self._told = False

    def wait_for(self, sources: Iterable[str]) -> None:
        """The topics that have to deliver for each step."""
        self._awaited = set(sources)

    def admit(self, sources: Iterable[str], topic: str, stamp_ns: int, start_ns: int) -> None:
        """Check in a message on `topic` that delivers for `sources`.

        Raises WrongStampError unless it belongs to the next step and is the first for all of them.
        """
        if stamp_ns != start_ns:
            raise WrongStampError(
                f"message on {topic} refused in lockstep: header.stamp is {stamp_ns} ns, but the "
                f"next step starts at {start_ns} ns"
            )
        delivering = {topic, *sources}
        again = sorted(delivering & self._delivered)
        if again:
            raise WrongStampError(
                f"message on {topic} refused in lockstep: the one for {again[0]} and the step that "
                f"starts at {start_ns} ns was already delivered"
            )
        self._delivered |= delivering

    @property
    def complete(self) -> bool:
        """Every source has delivered; never true without any source."""
        return bool(self._awaited) and self._awaited <= self._delivered

    def next_step(self) -> None:
        """The step is made: wait for the messages of the next one."""
        self._delivered.clear()
        self._since, self._told = None, False

    def overdue(self) -> list[str]:
        """The topics a step waits for; once for each step, when that takes long."""
        now = time.monotonic()
        self._since = now if self._since is None else self._since
        if self._told or now < self._since + PATIENCE:
            return []
        self._told = True
        return sorted(self._awaited - self._delivered)
