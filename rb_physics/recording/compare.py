"""Where two recordings part: the poses they logged at the same times."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .mcap_log import RecordingError
from .tables import Tables, read_tables


class BodyComparison(NamedTuple):
    """One body in two recordings."""

    body: str
    parts_at: float | None  # s; the first common time at which its poses differ
    largest_distance: float  # m, between its positions
    largest_at: float  # s
    last_distance: float  # m, at the last common time


class Comparison(NamedTuple):
    """Two recordings, body by body."""

    bodies: tuple[BodyComparison, ...]
    start: float  # s, first common time
    end: float  # s, last common time
    spans: tuple[tuple[float, float], tuple[float, float]]  # s, first and last time of each
    missing: tuple[str, ...]  # bodies that only one of them has

    @property
    def identical(self) -> bool:
        return not self.missing and all(b.parts_at is None for b in self.bodies)

    @property
    def text(self) -> str:
        """A table for people."""
        lines = [f"compared from {self.start:.3f} to {self.end:.3f} s"]
        if self.spans[0] != self.spans[1]:
            first, second = (f"from {since:.3f} to {until:.3f} s" for since, until in self.spans)
            lines.append(f"the first goes {first}, the second {second}")
        if self.identical:
            return "\n".join([*lines, "identical poses"])
        parted = [b for b in self.bodies if b.parts_at is not None]
        if parted:
            # Of several at one logged moment the one that comes to differ most: it was pushed.
            earliest = min(parted, key=lambda b: (b.parts_at or 0.0, -b.largest_distance))
            lines.append(f"they part at {earliest.parts_at:.3f} s, body {earliest.body} first")
            lines.append(
                f"{'body':<20} {'parts at':>10} {'largest':>12} {'at':>10} {'at the end':>12}"
            )
        for b in parted:
            lines.append(
                f"{b.body:<20} {b.parts_at:>8.3f} s {b.largest_distance:>10.3g} m "
                f"{b.largest_at:>8.3f} s {b.last_distance:>10.3g} m"
            )
        same = len(self.bodies) - len(parted)
        lines.append(f"{same} other bodies are identical" if parted else "")
        if self.missing:
            lines.append(f"only one of them has: {', '.join(self.missing)}")
        return "\n".join(line for line in lines if line)


def compare(first: str | Path, second: str | Path) -> Comparison:
    """Raises RecordingError when they have no time or no body in common."""
    a, b = read_tables(first), read_tables(second)
    common = [name for name in a.bodies if name in b.bodies]
    in_a, in_b = _present(a, b), _present(b, a)
    missing = [n for n in (*a.bodies, *b.bodies) if (n in in_a) != (n in in_b)]
    results = []
    start, end = np.inf, -np.inf
    for name in common:
        time, pose_a, pose_b = _matched(a, b, name)
        if not len(time):
            continue
        start, end = min(start, time[0]), max(end, time[-1])
        distance = np.linalg.norm(pose_a[:, :3] - pose_b[:, :3], axis=1)
        differs = np.nonzero(np.any(pose_a != pose_b, axis=1))[0]
        at = int(np.argmax(distance))
        results.append(
            BodyComparison(
                name,
                float(time[differs[0]]) if len(differs) else None,
                float(distance[at]),
                float(time[at]),
                float(distance[-1]),
            )
        )
    if not results:
        raise RecordingError(f"{first} and {second} have no poses of one body at one time")
    spans = (_span(a), _span(b))
    return Comparison(tuple(results), float(start), float(end), spans, tuple(missing))


def distances(first: str | Path, second: str | Path) -> dict[str, tuple[NDArray, NDArray]]:
    """Of each body in both: common times (s), and the distance of its positions there (m)."""
    a, b = read_tables(first), read_tables(second)
    found = {}
    for name in a.bodies:
        if name in b.bodies:
            time, pose_a, pose_b = _matched(a, b, name)
            found[name] = (time, np.linalg.norm(pose_a[:, :3] - pose_b[:, :3], axis=1))
    return found


def _span(tables: Tables) -> tuple[float, float]:
    times = tables.poses["time"]
    return float(times.min()), float(times.max())


def _present(tables: Tables, other: Tables) -> set[str]:
    """Bodies with poses in the time that both recordings cover."""
    times = other.poses["time"]
    if not len(times):
        return set()
    inside = (tables.poses["time"] >= times.min()) & (tables.poses["time"] <= times.max())
    return {tables.bodies[row] for row in np.unique(tables.poses["body"][inside])}


def _matched(a: Tables, b: Tables, name: str) -> tuple[NDArray, NDArray, NDArray]:
    """Common times (in ns exact) and the poses of one body there, (T, 7) each."""

    def of(tables: Tables) -> tuple[NDArray, NDArray]:
        rows = tables.poses[tables.poses["body"] == tables.bodies.index(name)]
        stamps, last = np.unique(
            np.rint(rows["time"] * 1e9).astype(np.int64)[::-1], return_index=True
        )
        rows = rows[::-1][last]
        return stamps, np.hstack((rows["position"], rows["orientation"]))

    times_a, poses_a = of(a)
    times_b, poses_b = of(b)
    common, in_a, in_b = np.intersect1d(times_a, times_b, return_indices=True)
    return common / 1e9, poses_a[in_a], poses_b[in_b]
