"""Applied wrenches: which sources push which body now, since when and until which step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

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


@dataclass(frozen=True)
class HeldWrench:
    """What a source applies until it sends another wrench or it expires."""

    wrench: BodyWrench
    from_step: int
    until_step: int | None  # first step in which it acts no more; None: held forever


class WrenchInputs:
    """Held wrenches of all sources, summed up per body.

    Everything is counted in steps, so that the same messages at the same steps always act in the
    same steps. Only the physics thread touches an object of this class.

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
        self._held: dict[int, HeldWrench] = {}
        self._by_body: dict[str, list[int]] = {}
        for index, source in enumerate(self.sources):
            self._by_body.setdefault(source.body, []).append(index)
        self._changed: set[str] = set()
        self._acting: dict[str, BodyWrench] = {}
        self.set_timeout(timeout)

    def set_timeout(self, timeout: float) -> None:
        """How long wrenches that arrive from now on are held."""
        if not (timeout >= 0.0 or timeout == FOREVER) or math.isinf(timeout):
            raise ValueError(
                f"wrench_timeout is {timeout}, but must be >= 0 s, or -1 to hold a wrench for ever"
            )
        # The tiny term keeps 0.1 s / 0.001 s at 100 steps in spite of rounding.
        steps = max(1, math.ceil(timeout / self._dt - 1e-6))
        self._hold_steps = None if timeout == FOREVER else steps

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

    def hold(self, source: int, wrench: BodyWrench, step: int) -> None:
        """Let a wrench act from step `step` on, instead of what the same source sent before."""
        until = None if self._hold_steps is None else step + self._hold_steps
        self._held[source] = HeldWrench(wrench, step, until)
        self._changed.add(self.sources[source].body)

    def clear(self) -> None:
        """Let go of every wrench."""
        for index in self._held:
            self._changed.add(self.sources[index].body)
        self._held.clear()

    @property
    def active(self) -> int:
        """Number of sources that push now."""
        return len(self._held)

    def steps_unchanged(self, step: int) -> int | None:
        """For how many steps from `step` on the wrenches of the last `apply` stay right.

        None when nothing ever expires.
        """
        if any(self._is_mixed(body) for body in self._acting):
            return 1
        expiries = [h.until_step for h in self._held.values() if h.until_step is not None]
        return max(1, min(expiries) - step) if expiries else None

    def apply(self, world: Any, step: int, perform: Perform) -> None:
        """Set the wrenches that act in step `step` on the bodies of `world`."""
        for index in [
            i for i, h in self._held.items() if h.until_step is not None and h.until_step <= step
        ]:
            del self._held[index]
            self._changed.add(self.sources[index].body)
        for body in self._by_body:  # in topic order
            if body not in self._changed and not self._is_mixed(body):
                continue
            total = self._total(world, body)
            if total is None:
                if self._acting.pop(body, None) is not None:
                    perform("clear_wrenches", body=body)
                continue
            self._acting[body] = total
            perform(
                "apply_wrench",
                body=body,
                force=total.force,
                torque=total.torque,
                frame="body" if total.in_body_axes else "world",
            )
        self._changed.clear()

    def _held_on(self, body: str) -> list[BodyWrench]:
        return [self._held[i].wrench for i in self._by_body[body] if i in self._held]

    def _is_mixed(self, body: str) -> bool:
        """Body-axes and world-axes wrenches together: their sum changes as the body turns."""
        return len({wrench.in_body_axes for wrench in self._held_on(body)}) > 1

    def _total(self, world: Any, body: str) -> BodyWrench | None:
        wrenches = self._held_on(body)
        if not wrenches:
            return None
        if not self._is_mixed(body):
            return BodyWrench(
                wrenches[0].in_body_axes,
                _sum([wrench.force for wrench in wrenches]),
                _sum([wrench.torque for wrench in wrenches]),
            )
        orientation = world[body].orientation
        turned = [
            (rotate(orientation, w.force), rotate(orientation, w.torque))
            if w.in_body_axes
            else (w.force, w.torque)
            for w in wrenches
        ]
        return BodyWrench(False, _sum([f for f, _ in turned]), _sum([t for _, t in turned]))


def rotate(orientation: Sequence[float], u: Vector) -> Vector:
    """`u` turned by the unit quaternion `orientation` (x, y, z, w)."""
    x, y, z, w = (float(value) for value in orientation)
    # u + 2 w (q × u) + 2 q × (q × u)
    cx, cy, cz = y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]
    return (
        u[0] + 2 * (w * cx + y * cz - z * cy),
        u[1] + 2 * (w * cy + z * cx - x * cz),
        u[2] + 2 * (w * cz + x * cy - y * cx),
    )


def _sum(vectors: Sequence[Vector]) -> Vector:
    x, y, z = vectors[0]
    for vector in vectors[1:]:
        x, y, z = x + vector[0], y + vector[1], z + vector[2]
    return (x, y, z)
