"""Which applied wrenches act at a moment, as the logged operations tell of them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription
from .operations import Operation
from .quaternions import rotate_inverse


class HeldWrench(NamedTuple):
    """A wrench that is applied until it is replaced, cleared or over."""

    place: NDArray  # m, body coordinates
    force: NDArray  # N, in the body's or the world's axes
    torque: NDArray  # N m, likewise
    in_body: bool
    until: float  # ns of log time; inf: for ever


class HeldWrenches:
    """Follows the operations of a log. Each wrench is taken to act for `shortest` ns at least."""

    def __init__(self, shortest: float = 0.0) -> None:
        self._shortest = shortest
        self._bodies: Sequence[BodyDescription] = ()
        self._row_of: dict[str, int] = {}
        self._held: dict[tuple[str, int], HeldWrench] = {}  # by body and source

    def set_bodies(self, bodies: Sequence[BodyDescription]) -> None:
        """The bodies are these now; what acts on those that stay goes on."""
        self._bodies = bodies
        self._row_of = {body.name: row for row, body in enumerate(bodies)}
        self._held = {key: held for key, held in self._held.items() if key[0] in self._row_of}

    def take(self, time_ns: int, operation: Operation, poses: NDArray) -> None:
        """One logged operation; `poses` (N, 7) as last seen."""
        arguments = operation.arguments
        if operation.name in ("reset", "reset_state"):
            self._held.clear()
        elif operation.name == "clear_wrenches":
            body, source = arguments.get("body"), arguments.get("source")
            for key in list(self._held):
                if body in (None, key[0]) and source in (None, key[1]):
                    del self._held[key]
        elif operation.name == "apply_wrench":
            self._hold(time_ns, arguments, poses)
        elif operation.name == "apply_wrenches":
            common = {name: arguments[name] for name in ("frame", "duration")}
            for body, source, row in zip(
                arguments["bodies"], arguments["sources"], arguments["wrenches"], strict=True
            ):
                one = {"body": body, "source": source, "force": row[:3], "torque": row[3:]}
                self._hold(time_ns, one | common, poses)

    def _hold(self, time_ns: int, arguments: Mapping[str, Any], poses: NDArray) -> None:
        if arguments["body"] in self._row_of:
            key = (arguments["body"], int(arguments.get("source") or 0))
            self._held[key] = self._wrench(time_ns, arguments, poses)

    def _wrench(self, time_ns: int, arguments: Mapping[str, Any], poses: NDArray) -> HeldWrench:
        row = self._row_of[arguments["body"]]
        in_body = arguments.get("frame", "world") == "body"
        point = arguments.get("point")
        if point is None:
            place = np.array(self._bodies[row].center_of_mass)
        elif in_body or row >= len(poses):
            place = np.array(point)
        else:
            pose = poses[row]
            place = rotate_inverse(pose[None, 3:], (np.array(point) - pose[:3])[None])[0]
        duration = arguments.get("duration")
        until = math.inf if duration is None else time_ns + max(duration * 1e9, self._shortest)
        force, torque = (np.array(arguments.get(n, (0.0, 0.0, 0.0))) for n in ("force", "torque"))
        return HeldWrench(place, force, torque, in_body, until)

    def acting(self, time_ns: float) -> list[tuple[int, HeldWrench]]:
        """Row of the body and wrench of everything that acts at a time."""
        return [
            (self._row_of[body], held)
            for (body, _), held in self._held.items()
            if time_ns <= held.until
        ]

    def to_json(self, time_ns: float) -> str:
        """What acts behind a time, for `load` in a log that begins there."""
        rows = [
            {
                "body": body,
                "source": source,
                "place": held.place.tolist(),
                "force": held.force.tolist(),
                "torque": held.torque.tolist(),
                "frame": "body" if held.in_body else "world",
                "until": None if math.isinf(held.until) else held.until * 1e-9,
            }
            for (body, source), held in self._held.items()
            if time_ns < held.until
        ]
        return json.dumps(rows)

    def load(self, text: str) -> None:
        """Raises ValueError for text that `to_json` doesn't write."""
        try:
            for row in json.loads(text):
                place, force, torque = (
                    np.array(row[name], np.float64).reshape(3)
                    for name in ("place", "force", "torque")
                )
                until = math.inf if row["until"] is None else float(row["until"]) * 1e9
                if row["body"] in self._row_of:
                    self._held[row["body"], int(row["source"])] = HeldWrench(
                        place, force, torque, row["frame"] == "body", until
                    )
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"logged wrenches are damaged: {error!r}") from None
