"""Applied wrenches: what each source pushes with, handed to the world at step boundaries."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .refused import RefusedBodyError, RefusedValueError
from .wrench_frames import BODY_PATTERN, COM, WORLD, BodyWrench, Vector, WrenchFrames

FOREVER = -1.0
Perform = Callable[..., None]  # changes the world by an operation's name and arguments, logging it


@dataclass(frozen=True)
class WrenchSource:
    """A wrench topic. Sources of a body add up in the order they are listed in."""

    topic: str
    body: str | None  # None: a batched topic, a source of every body


@dataclass(frozen=True)
class HeldWrenches:
    """What a message means: wrenches at the centres of mass of some bodies."""

    bodies: tuple[str, ...]
    in_body_axes: bool
    values: NDArray[np.float64]  # (N, 6) N, N m

    @classmethod
    def of(cls, body: str, wrench: BodyWrench) -> HeldWrenches:
        """A single one."""
        return cls((body,), wrench.in_body_axes, np.array([[*wrench.force, *wrench.torque]]))


class WrenchInputs:
    """Takes in wrench messages and hands them to the world, each source held on its own.

    The world adds the sources of a body up and lets each expire. Only the physics thread touches
    an object of this class.

    Parameters
    ----------
    dt: length of a step, s.
    timeout: how long a wrench is held, s of simulation time; 0 means one step, -1 for ever.
    """

    def __init__(self, dt: float, timeout: float) -> None:
        self._dt = dt
        self._frames: dict[str, WrenchFrames] = {}
        self._rank: dict[str, int] = {}  # of a topic
        self._number: dict[tuple[str, str], int] = {}  # (topic, body) -> source among the body's
        self._waiting: dict[str, HeldWrenches] = {}  # by topic
        self._checked: tuple[str, ...] = ()  # bodies of a batch that are known to be right
        self._until: dict[tuple[str, str], float] = {}  # -> first step in which it acts no more
        self.set_timeout(timeout)

    def fit(self, sources: Sequence[WrenchSource], frames: Mapping[str, WrenchFrames]) -> None:
        """The wrench topics, in their order, and the dynamic bodies with their valid frames.

        Called again when bodies were added or removed; what is held on the others goes on.
        """
        self._frames = dict(frames)
        self._rank = {source.topic: rank for rank, source in enumerate(sources)}
        self._number = {}
        seen: Counter[str] = Counter()
        for source in sources:
            for body in self._frames if source.body is None else [source.body]:
                self._number[source.topic, body] = seen[body]
                seen[body] += 1
        self._until = {key: until for key, until in self._until.items() if key in self._number}
        self._checked = ()
        for topic, held in list(self._waiting.items()):
            left = [i for i, body in enumerate(held.bodies) if (topic, body) in self._number]
            self._waiting[topic] = HeldWrenches(
                tuple(held.bodies[i] for i in left), held.in_body_axes, held.values[left]
            )

    def set_timeout(self, timeout: float) -> None:
        """How long wrenches that arrive from now on are held."""
        if not (timeout >= 0.0 or timeout == FOREVER) or math.isinf(timeout):
            raise ValueError(
                f"wrench_timeout is {timeout}, but must be >= 0 s, or -1 to hold a wrench for ever"
            )
        self._duration = None if timeout == FOREVER else float(timeout)

    def resolve(self, body: str, frame_id: str, force: Vector, torque: Vector) -> BodyWrench:
        """The wrench at the centre of mass that a message means.

        Raises RefusedValueError for numbers that are not finite, UnknownFrameError.
        """
        if not all(map(math.isfinite, force)) or not all(map(math.isfinite, torque)):
            raise RefusedValueError(
                f"wrench on body '{body}' refused: force {force} and torque {torque} must be finite"
            )
        return self._frames[body].resolve(frame_id, force, torque)

    def resolve_batch(
        self, topic: str, frame_id: str, bodies: tuple[str, ...], wrenches: NDArray[np.float64]
    ) -> HeldWrenches:
        """The wrenches of a batched message; the literal NAME in `frame_id` stands for each body.

        Raises RefusedInputError: then nothing of the message acts.
        """
        if len(bodies) != len(wrenches):
            raise RefusedValueError(
                f"message on {topic} refused: {len(bodies)} joint_names but {len(wrenches)} "
                "wrenches; give one for each"
            )
        if bodies is not self._checked:
            self._check_names(topic, bodies)
            self._checked = bodies
        if frame_id in (WORLD, f"{BODY_PATTERN}/{COM}") and np.isfinite(wrenches).all():
            return HeldWrenches(bodies, frame_id != WORLD, wrenches)
        pattern = frame_id == BODY_PATTERN or frame_id.startswith(f"{BODY_PATTERN}/")
        rows, in_body_axes = [], False
        for body, (fx, fy, fz, tx, ty, tz) in zip(bodies, wrenches.tolist(), strict=True):
            frame = body + frame_id.removeprefix(BODY_PATTERN) if pattern else frame_id
            resolved = self.resolve(body, frame, (fx, fy, fz), (tx, ty, tz))
            rows.append([*resolved.force, *resolved.torque])
            in_body_axes = resolved.in_body_axes
        return HeldWrenches(bodies, in_body_axes, np.array(rows).reshape(-1, 6))

    def _check_names(self, topic: str, bodies: tuple[str, ...]) -> None:
        for place, body in enumerate(bodies):
            if body not in self._frames:
                raise RefusedBodyError(
                    f"message on {topic} refused: there is no dynamic body '{body}'; there are "
                    f"{', '.join(self._frames) or 'none'}"
                )
            if body in bodies[:place]:
                raise RefusedBodyError(f"message on {topic} refused: '{body}' is named twice")

    def hold(self, topic: str, wrenches: HeldWrenches) -> None:
        """Let wrenches act from the next step on, instead of what the same source sent before."""
        self._waiting[topic] = wrenches

    def apply(self, step: int, perform: Perform) -> None:
        """Hand over what was held since the last step, in topic order; `step` is the next one."""
        if not self._waiting:
            return
        for topic in sorted(self._waiting, key=lambda name: self._rank.get(name, -1)):
            held = self._waiting[topic]
            named = set(held.bodies)
            for key in [k for k in self._until if k[0] == topic and k[1] not in named]:
                if step < self._until.pop(key):  # the batch names this body no longer
                    perform("clear_wrenches", body=key[1], source=self._number[key])
            self._hand_over(topic, held, perform)
            duration = self._duration
            until = math.inf if duration is None else step + max(1.0, duration / self._dt - 1e-6)
            for body in held.bodies:
                self._until[topic, body] = until
        self._waiting.clear()

    def _hand_over(self, topic: str, held: HeldWrenches, perform: Perform) -> None:
        frame = "body" if held.in_body_axes else "world"
        if len(held.bodies) == 1:
            (body,) = held.bodies
            perform(
                "apply_wrench",
                body=body,
                force=held.values[0, :3],
                torque=held.values[0, 3:],
                frame=frame,
                duration=self._duration,
                source=self._number[topic, body],
            )
        elif held.bodies:
            perform(
                "apply_wrenches",
                bodies=list(held.bodies),
                sources=[self._number[topic, body] for body in held.bodies],
                wrenches=held.values,
                frame=frame,
                duration=self._duration,
            )

    def clear(self, step: int, perform: Perform) -> int:
        """Let go of every wrench; returns how many sources were pushing."""
        count = self.active(step)
        for body in dict.fromkeys(body for _, body in self._until):
            perform("clear_wrenches", body=body)
        self._until.clear()
        self._waiting.clear()
        return count

    def active(self, step: int) -> int:
        """Number of sources that push in step `step`, counted for each body."""
        acting = {key for key, until in self._until.items() if step < until}
        waiting = {(topic, body) for topic, held in self._waiting.items() for body in held.bodies}
        return len(acting | waiting)
