"""Contacts in the Rerun view: points, forces where they act, coloured by how near they are to slip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .decoders import PointCloudDecoder
from .geometry import BodyDescription
from .palette import FORCE, ForceArrows, cone_colors, typical_radius
from .rerun_batch import Batch


class ContactEntities:
    """`world/contact_points` and `world/contact_forces` of one set of bodies."""

    def __init__(
        self,
        recording: Any,
        bodies: Sequence[BodyDescription],
        arrows: ForceArrows,
        friction_combine: str,
        batch: int,
    ) -> None:
        import rerun

        self._rr, self._rec, self._arrows = rerun, recording, arrows
        self._combine = _COMBINE[friction_combine]
        known = all(body.friction is not None for body in bodies)
        self._friction = np.array([b.friction for b in bodies], np.float32) if known else None
        self._decode = PointCloudDecoder()
        self._batch: Batch[NDArray] = Batch(batch, self._send)
        radius = 0.035 * typical_radius(bodies)
        # What is logged as static hides what comes with time.
        color: dict[str, Any] = {} if known else {"colors": [FORCE]}
        points = rerun.Points3D.from_fields(radii=[1.5 * radius], **color)
        recording.log("world/contact_points", points, static=True)
        forces = rerun.Arrows3D.from_fields(radii=[radius], **color)
        recording.log("world/contact_forces", forces, static=True)

    def add(self, time_ns: int, data: bytes) -> NDArray:
        """One message of ~/contacts; its rows."""
        points = self._decode(data)[2]
        self._batch.add(time_ns, points)
        return points

    def flush(self) -> None:
        self._batch.flush()

    def _send(self, index: Any, samples: list[NDArray]) -> None:
        rr = self._rr
        counts = [len(sample) for sample in samples]
        points = _joined(samples)
        places = _vectors(points, "x", "y", "z")
        forces = _vectors(points, "fx", "fy", "fz")
        colored = {"colors": self.colors(points, forces)} if self._friction is not None else {}
        columns = rr.Points3D.columns(positions=places, **colored).partition(counts)
        self._rec.send_columns("world/contact_points", indexes=[index], columns=columns)
        carrying = np.any(forces != 0, axis=1)
        sample_of = np.repeat(np.arange(len(counts)), counts)
        drawn = np.bincount(sample_of[carrying], minlength=len(counts))
        columns = rr.Arrows3D.columns(
            origins=places[carrying],
            vectors=self._arrows.vectors(forces[carrying]),
            **{name: values[carrying] for name, values in colored.items()},
        ).partition(drawn)
        self._rec.send_columns("world/contact_forces", indexes=[index], columns=columns)

    def colors(self, points: NDArray, forces: NDArray) -> NDArray:
        """RGBA (N, 4): the share of the friction cone each force uses."""
        assert self._friction is not None
        normals = _vectors(points, "nx", "ny", "nz")
        last = len(self._friction) - 1
        a, b = (self._friction[np.clip(points[n], 0, last)] for n in ("body_a", "body_b"))
        pressing = np.einsum("ij,ij->i", normals, forces)
        across = forces - pressing[:, None] * normals
        tangential = np.sqrt(np.einsum("ij,ij->i", across, across))
        allowed = self._combine(a, b) * pressing
        share = np.divide(
            tangential, allowed, out=np.zeros(len(points), np.float32), where=allowed > 0
        )
        return cone_colors(share)


def _joined(samples: list[NDArray]) -> NDArray:
    """np.concatenate, which takes long to find out that dtypes with many fields are one."""
    dtype = samples[0].dtype
    if all(sample.dtype is dtype for sample in samples):
        return np.frombuffer(b"".join(sample.tobytes() for sample in samples), dtype)
    return np.concatenate(samples)


def _vectors(points: NDArray, *names: str) -> NDArray:
    vectors = np.empty((len(points), len(names)), np.float32)  # as they are published
    for column, name in enumerate(names):
        vectors[:, column] = points[name]
    return vectors


_COMBINE: dict[str, Callable[[NDArray, NDArray], NDArray]] = {  # of `Settings.friction_combine`
    "geometric_mean": lambda a, b: np.sqrt(a * b),
    "mean": lambda a, b: (a + b) / 2,
    "min": np.minimum,
    "max": np.maximum,
    "product": lambda a, b: a * b,
}
