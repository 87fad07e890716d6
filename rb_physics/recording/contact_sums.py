"""Contact impulses summed up between the messages that tell of them, and the frames they are told
in.

Sums belong to bodies by name, so that nothing is lost when bodies come and go in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .quaternions import cross, multiply, rotate, rotate_inverse
from .topics import Topic

Subject = tuple[str, str | None]  # a body, and the other one of a pair


class ContactSum:
    """Impulse (3, N s) and angular impulse about the moving centre of mass (3, N m s) of each topic
    of a group, world axes, since the last message."""

    def __init__(self, topics: Sequence[Topic], now_ns: float) -> None:
        self.subjects: list[Subject] = [(str(topic.body), topic.other) for topic in topics]
        self.values = np.zeros((len(topics), 6))
        self.since_ns = now_ns

    def inherit(self, earlier: ContactSum) -> None:
        """Goes on from the sum of another set of bodies."""
        kept = dict(zip(earlier.subjects, earlier.values, strict=True))
        for row, subject in enumerate(self.subjects):
            if subject in kept:
                self.values[row] += kept[subject]
        self.since_ns = earlier.since_ns

    def mean(self, now_ns: float) -> NDArray:
        """(N, 6) N and N m over the time since the last message, which begins anew."""
        interval = (now_ns - self.since_ns) * 1e-9
        mean = self.values / interval if interval > 0 else np.zeros_like(self.values)
        self.values[:] = 0.0
        self.since_ns = now_ns
        return mean


class ContactSums:
    """The sums of all groups of contact topics of one world."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._sums: dict[Any, ContactSum] = {}
        self._earlier: dict[Any, ContactSum] = {}
        self._rows: dict[Any, NDArray] = {}  # of the bodies of a group
        self._pairs: dict[Any, dict[tuple[int, int], int]] = {}  # rows of a pair -> its topic

    def rebuild(self) -> None:
        """The bodies are others now: `open` each group again."""
        self._earlier, self._sums = self._sums, {}
        self._rows, self._pairs = {}, {}
        self._world.keep_pair_impulses = False

    def open(self, key: Any, topics: Sequence[Topic], row_of: dict[str, int], now: int) -> None:
        """A group of topics, all of single bodies or all of pairs."""
        self._sums[key] = ContactSum(topics, now)
        if key in self._earlier:
            self._sums[key].inherit(self._earlier[key])
        rows = [row_of[str(topic.body)] for topic in topics]
        if topics[0].other is None:
            self._rows[key] = np.array(rows, np.intp)
            return
        others = [row_of[str(topic.other)] for topic in topics]
        self._pairs[key] = {pair: i for i, pair in enumerate(zip(rows, others, strict=True))}
        self._world.keep_pair_impulses = True

    def restart(self, now: int) -> None:
        """Time has jumped: every sum begins anew."""
        self._world.drain_contact_impulses()
        self._world.drain_pair_impulses()
        for each in self._sums.values():
            each.values[:] = 0.0
            each.since_ns = now

    def drain(self) -> None:
        """Adds what the contacts did since the last call."""
        if self._rows:
            drained = self._world.drain_contact_impulses()
            for key, rows in self._rows.items():
                self._sums[key].values += drained[rows]
        if self._pairs:
            rows, sums = self._world.drain_pair_impulses()
            for (a, b), sum_of_pair in zip(rows.tolist(), sums, strict=True):
                for key, topic_of in self._pairs.items():
                    values = self._sums[key].values
                    if (at := topic_of.get((a, b))) is not None:
                        values[at] += sum_of_pair[:6]
                    if (at := topic_of.get((b, a))) is not None:
                        values[at, :3] -= sum_of_pair[:3]
                        values[at, 3:] += sum_of_pair[6:]

    def mean(self, key: Any, now: int) -> NDArray:
        """(N, 6) mean wrenches about the centres of mass, world axes."""
        return self._sums[key].mean(now)


class SensorFrames:
    """From wrenches about centres of mass in world axes to those about the reference points of
    topics, along the axes of their frames."""

    def __init__(self, topics: Sequence[Topic], bodies: Sequence[Any]) -> None:
        """`bodies`: the BodyDescription of each row."""
        row_of = {body.name: row for row, body in enumerate(bodies)}
        self._body = np.array([row_of[str(topic.body)] for topic in topics], np.intp)
        axes, points = [], []
        for topic in topics:
            axes.append(_place(topic.frame, row_of, bodies))
            points.append(_place(topic.reference_point or topic.frame, row_of, bodies))
        self._axes_row = np.array([row for row, _, _ in axes], np.intp)
        self._turned = self._axes_row >= 0
        self._axes = np.array([q for _, _, q in axes])
        self._point_row = np.array([row for row, _, _ in points], np.intp)
        self._point = np.array([p for _, p, _ in points])
        own = [f"{topic.body}/com" for topic in topics]
        # About its own centre of mass nothing is to be added, not even a rounding error.
        self._shifted = np.array(
            [(t.reference_point or t.frame) != com for t, com in zip(topics, own, strict=True)]
        )

    def express(self, world: Any, wrenches: NDArray) -> NDArray:
        """(N, 6), see the class."""
        force, torque = wrenches[:, :3], wrenches[:, 3:]
        if self._shifted.any():
            fixed = self._point_row >= 0
            q = world.orientations[self._point_row]
            points = np.where(
                fixed[:, None],
                world.positions[self._point_row] + rotate(q, self._point),
                self._point,
            )
            lever = world.com_positions[self._body] - points
            torque = torque + np.where(self._shifted[:, None], cross(lever, force), 0.0)
        if self._turned.any():
            q = multiply(world.orientations[self._axes_row], self._axes)
            q[~self._turned] = (0.0, 0.0, 0.0, 1.0)
            force, torque = rotate_inverse(q, force), rotate_inverse(q, torque)
        return np.hstack((force, torque))


def _place(frame: str, row_of: dict[str, int], bodies: Sequence[Any]) -> tuple[int, Any, Any]:
    """(row or -1 for the world, origin, orientation) of a frame."""
    identity = (0.0, 0.0, 0.0, 1.0)
    if frame == "world":
        return -1, (0.0, 0.0, 0.0), identity
    name, _, part = frame.partition("/")
    body = bodies[row_of[name]]
    if not part:
        return row_of[name], (0.0, 0.0, 0.0), identity
    if part == "com":
        return row_of[name], body.center_of_mass, identity
    position, orientation = body.frames[part]
    return row_of[name], position, orientation
