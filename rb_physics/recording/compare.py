"""Where two recordings part: what they logged of their bodies at the same moments."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .errors import RecordingError
from .motions import Motions, read_motions

UNITS = {
    "position": "m",
    "orientation": "rad",
    "linear velocity": "m/s",
    "angular velocity": "rad/s",
}


class Difference(NamedTuple):
    """One quantity of one body in two recordings, at their common moments."""

    quantity: str  # one of UNITS
    parts_at: float | None  # s; the first moment at which it differs by a bit
    largest: float  # in the quantity's unit; of an orientation the angle between both
    largest_at: float  # s
    last: float  # at the last common moment


class BodyComparison(NamedTuple):
    """One body in two recordings."""

    body: str
    differences: tuple[Difference, ...]  # position, orientation, velocities where both have them

    @property
    def parts_at(self) -> float | None:
        """s; the first moment at which anything of it differs."""
        times = [d.parts_at for d in self.differences if d.parts_at is not None]
        return min(times, default=None)

    @property
    def largest_distance(self) -> float:
        """m, between its positions."""
        return self.differences[0].largest

    @property
    def largest_angle(self) -> float:
        """rad, between its orientations."""
        return self.differences[1].largest


class Comparison(NamedTuple):
    """Two recordings, body by body."""

    bodies: tuple[BodyComparison, ...]
    start: float  # s, first common moment
    end: float  # s, last common moment
    spans: tuple[tuple[float, float], tuple[float, float]]  # s, first and last time of each
    missing: tuple[str, ...]  # bodies that only one of them has
    states_part_at: float | None  # s, end of the first step with another state hash

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
        if self.states_part_at is not None:
            lines.append(f"their states part in the step that ends at {self.states_part_at:.9g} s")
        if self.identical:
            if any(len(b.differences) > 2 for b in self.bodies):
                lines.append("identical velocities")
            return "\n".join([*lines, "identical poses"])
        parted = [b for b in self.bodies if b.parts_at is not None]
        if parted:
            lines += [
                self._first_of(parted),
                _row("body", "", "parts at", "largest", "at", "at the end"),
            ]
        for b in parted:
            name = b.body
            for d in b.differences:
                if d.parts_at is not None:
                    unit = UNITS[d.quantity]
                    lines.append(_row(
                        name, d.quantity, f"{d.parts_at:.3f} s", f"{d.largest:.3g} {unit}",
                        f"{d.largest_at:.3f} s", f"{d.last:.3g} {unit}",
                    ))  # fmt: skip
                    name = ""
        same = len(self.bodies) - len(parted)
        lines.append(f"{same} other bodies are identical" if parted else "")
        if self.missing:
            lines.append(f"only one of them has: {', '.join(self.missing)}")
        return "\n".join(line for line in lines if line)

    def _first_of(self, parted: list[BodyComparison]) -> str:
        # Of several at one logged moment the one that comes to differ most: it was pushed.
        earliest = min(
            parted, key=lambda b: (b.parts_at or 0.0, -b.largest_distance, -b.largest_angle)
        )
        what = [d.quantity for d in earliest.differences if d.parts_at == earliest.parts_at]
        return (
            f"they part at {earliest.parts_at:.3f} s, body {earliest.body} first: {', '.join(what)}"
        )


def _row(name: str, quantity: str, *cells: str) -> str:
    parts_at, largest, at, last = cells
    return f"{name:<20} {quantity:<16} {parts_at:>10} {largest:>15} {at:>10} {last:>15}".rstrip()


class Series(NamedTuple):
    """How far one quantity of a body is apart in two recordings."""

    time: NDArray  # (T,) s, common moments; not falling, twice where the body was moved at one
    apart: NDArray  # (T,) in the quantity's unit
    differs: NDArray  # (T,) bool: by a bit, even where `apart` is rounded to zero


def compare(first: str | Path, second: str | Path) -> Comparison:
    """Raises RecordingError when they have no time or no body in common."""
    a, b = read_motions(first), read_motions(second)
    in_a, in_b = _present(a, b), _present(b, a)
    missing = [n for n in dict.fromkeys((*a.bodies, *b.bodies)) if (n in in_a) != (n in in_b)]
    results = []
    start, end = np.inf, -np.inf
    for name, series in _apart(a, b).items():
        time = series["position"].time
        start, end = min(start, time[0]), max(end, time[-1])
        results.append(BodyComparison(name, tuple(_summed(q, s) for q, s in series.items())))
    if not results:
        raise RecordingError(f"{first} and {second} have no poses of one body at one time")
    spans = (_span(a), _span(b))
    return Comparison(
        tuple(results), float(start), float(end), spans, tuple(missing), _states_part_at(a, b)
    )


def differences(first: str | Path, second: str | Path) -> dict[str, dict[str, Series]]:
    """Of each body in both: by quantity, in the order of UNITS, how far it is apart over time."""
    return _apart(read_motions(first), read_motions(second))


def _summed(quantity: str, series: Series) -> Difference:
    at = int(np.argmax(series.apart))
    differs = np.nonzero(series.differs)[0]
    return Difference(
        quantity,
        float(series.time[differs[0]]) if len(differs) else None,
        float(series.apart[at]),
        float(series.time[at]),
        float(series.apart[-1]),
    )


def _apart(a: Motions, b: Motions) -> dict[str, dict[str, Series]]:
    found = {}
    for name in a.bodies:
        if name not in b.bodies:
            continue
        time, pose_a, pose_b = _matched(a, b, "poses", name)
        if not len(time):
            continue
        p, q = pose_a[:, 3:], pose_b[:, 3:]
        q = np.where(np.sum(p * q, axis=1, keepdims=True) < 0, -q, q)  # the same orientation
        found[name] = {
            "position": _distance(time, pose_a[:, :3], pose_b[:, :3]),
            "orientation": Series(time, _angle(p, q), np.any(p != q, axis=1)),
        }
        time, twist_a, twist_b = _matched(a, b, "velocities", name)
        if len(time):
            found[name]["linear velocity"] = _distance(time, twist_a[:, :3], twist_b[:, :3])
            found[name]["angular velocity"] = _distance(time, twist_a[:, 3:], twist_b[:, 3:])
    return found


def _distance(time: NDArray, a: NDArray, b: NDArray) -> Series:
    return Series(time, np.linalg.norm(a - b, axis=1), np.any(a != b, axis=1))


def _angle(p: NDArray, q: NDArray) -> NDArray:
    """rad, of the rotation between unit quaternions; also of angles whose cosine is 1 in doubles."""
    half = 2 * np.arctan2(np.linalg.norm(p - q, axis=1), np.linalg.norm(p + q, axis=1))
    angle: NDArray = 2 * half
    return angle


def _span(motions: Motions) -> tuple[float, float]:
    times = motions.poses["time"]
    return float(times.min() / 1e9), float(times.max() / 1e9)


def _present(motions: Motions, other: Motions) -> set[str]:
    """Bodies with poses in the time that both recordings cover."""
    times = other.poses["time"]
    if not len(times):
        return set()
    inside = (motions.poses["time"] >= times.min()) & (motions.poses["time"] <= times.max())
    return {motions.bodies[row] for row in np.unique(motions.poses["body"][inside])}


def _matched(a: Motions, b: Motions, field: str, name: str) -> tuple[NDArray, NDArray, NDArray]:
    """Common moments (s; in ns exact) and the samples (T, ...) of one body there."""

    def of(motions: Motions) -> tuple[NDArray, NDArray]:
        table = getattr(motions, field)
        rows = table[table["body"] == motions.bodies.index(name)][::-1]
        # Several at one moment are of one state, unless a program set it by itself: the last counts.
        moments, last = np.unique(rows[["time", "jumps"]], return_index=True)
        return moments, rows["values"][last]

    moments_a, values_a = of(a)
    moments_b, values_b = of(b)
    common, in_a, in_b = np.intersect1d(
        moments_a, moments_b, assume_unique=True, return_indices=True
    )
    return common["time"] / 1e9, values_a[in_a], values_b[in_b]


def _states_part_at(a: Motions, b: Motions) -> float | None:
    """s; where the hashes of both, if they can be compared, are not the same any more."""
    if a.dt != b.dt or a.hash_version != b.hash_version:
        return None
    steps, in_a, in_b = np.intersect1d(a.hashes[:, 0], b.hashes[:, 0], return_indices=True)
    differ = np.nonzero(a.hashes[in_a, 1] != b.hashes[in_b, 1])[0]
    return float(steps[differ[0]]) * a.dt if len(differ) else None
