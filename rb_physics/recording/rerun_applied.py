"""Applied wrenches in the Rerun view, as the logged operations tell of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription
from .held_wrenches import HeldWrenches
from .operations import Operation
from .palette import APPLIED, APPLIED_TORQUE, ForceArrows, typical_radius
from .quaternions import rotate
from .rerun_batch import Batch

_SHORTEST = 15_000_000  # ns a wrench is shown at least: a sample and a half of the view
_NOTHING = (np.zeros((0, 3)),) * 3


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
        self._lever = typical_radius(bodies)
        self._held: HeldWrenches = HeldWrenches(_SHORTEST) if before is None else before._held
        self._held.set_bodies(bodies)
        self._batch: Batch[tuple[NDArray, NDArray, NDArray]] = Batch(batch, self._send)
        radius = 0.035 * self._lever
        for name, color in (("forces", APPLIED), ("torques", APPLIED_TORQUE)):
            style = rerun.Arrows3D.from_fields(colors=[color], radii=[radius])
            recording.log(f"world/applied_{name}", style, static=True)

    def take(self, time_ns: int, operation: Operation, poses: NDArray) -> None:
        """One logged operation; `poses` (N, 7) as last seen."""
        self._held.take(time_ns, operation, poses)

    def load(self, text: str) -> None:
        """What acted already when the log began."""
        self._held.load(text)

    def add(self, time_ns: int, poses: NDArray) -> None:
        """A sample of the poses: where what is held acts now."""
        acting = self._held.acting(time_ns)
        if not acting:
            self._batch.add(time_ns, _NOTHING)
            return
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
