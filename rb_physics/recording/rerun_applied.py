"""Applied wrenches in the Rerun view, as the logged operations tell of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription
from .operations import Operation
from .palette import APPLIED, APPLIED_TORQUE, ForceArrows, typical_radius
from .quaternions import rotate, rotate_inverse
from .rerun_batch import Batch

_SHORTEST = 15_000_000  # ns a wrench is shown at least: a sample and a half of the view


_NOTHING = (np.zeros((0, 3)),) * 3


class _Wrench(NamedTuple):
    place: NDArray  # m, body coordinates
    force: NDArray  # N, in the body's or the world's axes
    torque: NDArray  # N m, likewise
    in_body: bool
    until: float  # ns


class AppliedWrenches:
    """`world/applied_forces` and `world/applied_torques` of one set of bodies."""

    def __init__(
        self,
        recording: Any,
        bodies: Sequence[BodyDescription],
        arrows: ForceArrows,
        batch: int,
        before: AppliedWrenches | None = None,
    ) -> None:
        """`before`: of the bodies as they were until now; what acts on those that stay goes on."""
        import rerun

        self._rr, self._rec, self._arrows = rerun, recording, arrows
        self._bodies = bodies
        self._row_of = {body.name: row for row, body in enumerate(bodies)}
        self._lever = typical_radius(bodies)
        held = {} if before is None else before._held
        self._held: dict[tuple[str, int], _Wrench] = {
            key: wrench for key, wrench in held.items() if key[0] in self._row_of
        }
        self._batch: Batch[tuple[NDArray, NDArray, NDArray]] = Batch(batch, self._send)
        radius = 0.035 * self._lever
        for name, color in (("forces", APPLIED), ("torques", APPLIED_TORQUE)):
            style = rerun.Arrows3D.from_fields(colors=[color], radii=[radius])
            recording.log(f"world/applied_{name}", style, static=True)

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

    def _hold(self, time_ns: int, arguments: dict[str, Any], poses: NDArray) -> None:
        if arguments["body"] in self._row_of:
            key = (arguments["body"], int(arguments.get("source") or 0))
            self._held[key] = self._wrench(time_ns, arguments, poses)

    def _wrench(self, time_ns: int, arguments: dict[str, Any], poses: NDArray) -> _Wrench:
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
        until = np.inf if duration is None else time_ns + max(duration * 1e9, _SHORTEST)
        force, torque = (np.array(arguments.get(n, (0.0, 0.0, 0.0))) for n in ("force", "torque"))
        return _Wrench(place, force, torque, in_body, until)

    def add(self, time_ns: int, poses: NDArray) -> None:
        """A sample of the poses: where what is held acts now."""
        if not self._held:
            self._batch.add(time_ns, _NOTHING)
            return
        acting = [
            (self._row_of[body], wrench)
            for (body, _), wrench in self._held.items()
            if time_ns <= wrench.until
        ]
        places, forces, torques = (np.zeros((len(acting), 3)) for _ in range(3))
        for i, (row, wrench) in enumerate(acting):
            q = poses[row : row + 1, 3:]
            places[i] = poses[row, :3] + rotate(q, wrench.place[None])[0]
            both = np.stack((wrench.force, wrench.torque))
            forces[i], torques[i] = rotate(q, both) if wrench.in_body else both
        self._batch.add(time_ns, (places, forces, torques))

    def flush(self) -> None:
        self._batch.flush()

    def _send(self, index: Any, samples: list[tuple[NDArray, NDArray, NDArray]]) -> None:
        counts = [len(places) for places, _, _ in samples]
        sample_of = np.repeat(np.arange(len(counts)), counts)
        places, forces, torques = (np.concatenate(parts) for parts in zip(*samples, strict=True))
        # A torque is drawn as long as the force that makes it at the edge of a typical body.
        for name, vectors in (("forces", forces), ("torques", torques / self._lever)):
            drawn = np.any(vectors != 0, axis=1)
            columns = self._rr.Arrows3D.columns(
                origins=places[drawn], vectors=self._arrows.vectors(vectors[drawn])
            ).partition(np.bincount(sample_of[drawn], minlength=len(counts)))
            entity = f"world/applied_{name}"
            self._rec.send_columns(entity, indexes=[index], columns=columns)
