"""Lockstep: a step is made only when every wrench source has sent the message for it."""

from __future__ import annotations

from .refused import WrongStampError


class Lockstep:
    """Which sources have delivered for the next step.

    The message for a step is the one whose header.stamp equals the step's start time; every other
    one is refused, and so is a second one of the same source, so that what acts never depends on
    the order of arrival.
    """

    def __init__(self, sources: int) -> None:
        self._sources = sources
        self._delivered: set[int] = set()

    def admit(self, source: int, topic: str, stamp_ns: int, start_ns: int) -> None:
        """Check a message in. Raises WrongStampError unless it belongs to the next step."""
        if stamp_ns != start_ns:
            raise WrongStampError(
                f"message on {topic} refused in lockstep: header.stamp is {stamp_ns} ns, but the "
                f"next step starts at {start_ns} ns"
            )
        if source in self._delivered:
            raise WrongStampError(
                f"message on {topic} refused in lockstep: the one for the step that starts at "
                f"{start_ns} ns was already delivered"
            )
        self._delivered.add(source)

    @property
    def complete(self) -> bool:
        """Every source has delivered; never true without any source."""
        return self._sources > 0 and len(self._delivered) == self._sources

    @property
    def missing(self) -> list[int]:
        """Sources that have not delivered yet."""
        return [source for source in range(self._sources) if source not in self._delivered]

    def next_step(self) -> None:
        """The step is made: wait for the messages of the next one."""
        self._delivered.clear()
