"""Applied wrenches: what each source pushes with, handed to the world at step boundaries."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .refused import RefusedValueError
from .wrench_frames import BodyWrench, Vector, WrenchFrames

FOREVER = -1.0
Perform = Callable[..., None]  # changes the world by an operation's name and arguments, logging it


@dataclass(frozen=True)
class WrenchSource:
    """One wrench topic of one body. Sources of a body add up in the order they are listed in."""

    body: str
    source: str  # "" for ~/bodies/NAME/wrench, SOURCE for ~/bodies/NAME/wrench/SOURCE
    topic: str


class WrenchInputs:
    """Takes in wrench messages and hands them to the world, each source held on its own.

    The world adds the sources of a body up and lets each expire. Only the physics thread touches
    an object of this class.

    Parameters
    ----------
    sources: every wrench topic, in topic order.
    frames: body name -> its valid frames.
    dt: length of a step, s.
    timeout: how long a wrench is held, s of simulation time; 0 means one step, -1 for ever.
    """

    def __init__(
        self,
        sources: Sequence[WrenchSource],
        frames: Mapping[str, WrenchFrames],
        dt: float,
        timeout: float,
    ) -> None:
        self.sources = tuple(sources)
        self._frames = dict(frames)
        self._dt = dt
        self._waiting: dict[int, BodyWrench] = {}
        self._until: dict[int, float] = {}  # source -> first step in which it acts no more
        seen: Counter[str] = Counter()
        self._number: list[int] = []  # of a source among those of its body
        for source in self.sources:
            self._number.append(seen[source.body])
            seen[source.body] += 1
        self.set_timeout(timeout)

    def set_timeout(self, timeout: float) -> None:
        """How long wrenches that arrive from now on are held."""
        if not (timeout >= 0.0 or timeout == FOREVER) or math.isinf(timeout):
            raise ValueError(
                f"wrench_timeout is {timeout}, but must be >= 0 s, or -1 to hold a wrench for ever"
            )
        self._duration = None if timeout == FOREVER else float(timeout)

    def resolve(self, source: int, frame_id: str, force: Vector, torque: Vector) -> BodyWrench:
        """The wrench at the centre of mass that a message means.

        Raises RefusedValueError for numbers that are not finite, UnknownFrameError.
        """
        body = self.sources[source].body
        if not all(map(math.isfinite, force)) or not all(map(math.isfinite, torque)):
            raise RefusedValueError(
                f"wrench on body '{body}' refused: force {force} and torque {torque} must be finite"
            )
        return self._frames[body].resolve(frame_id, force, torque)

    def hold(self, source: int, wrench: BodyWrench) -> None:
        """Let a wrench act from the next step on, instead of what the same source sent before."""
        self._waiting[source] = wrench

    def apply(self, step: int, perform: Perform) -> None:
        """Hand over what was held since the last step, in topic order; `step` is the next one."""
        for source in sorted(self._waiting):
            wrench = self._waiting[source]
            perform(
                "apply_wrench",
                body=self.sources[source].body,
                force=wrench.force,
                torque=wrench.torque,
                frame="body" if wrench.in_body_axes else "world",
                duration=self._duration,
                source=self._number[source],
            )
            duration = self._duration
            self._until[source] = (
                math.inf if duration is None else step + max(1.0, duration / self._dt - 1e-6)
            )
        self._waiting.clear()

    def clear(self, step: int, perform: Perform) -> int:
        """Let go of every wrench; returns how many sources were pushing."""
        count = self.active(step)
        for body in dict.fromkeys(self.sources[source].body for source in self._until):
            perform("clear_wrenches", body=body)
        self._until.clear()
        self._waiting.clear()
        return count

    def active(self, step: int) -> int:
        """Number of sources that push in step `step`."""
        acting = {source for source, until in self._until.items() if step < until}
        return len(acting | set(self._waiting))
