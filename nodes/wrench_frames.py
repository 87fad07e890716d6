"""The frames in which a wrench on a body may be given, and what each of them means.

A WrenchStamped acts at the origin of its ``header.frame_id``, along that frame's axes:

========== ======================= =====================================
frame_id   axes                    acts at
========== ======================= =====================================
NAME       body frame              origin of the body frame
NAME/com   body frame              centre of mass
NAME/FRAME the frame's own         the frame's origin (declared in the scene)
world      world                   centre of mass (the one exception)
========== ======================= =====================================
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from .refused import UnknownFrameError

Vector = tuple[float, float, float]

WORLD = "world"
COM = "com"
BODY_PATTERN = "NAME"  # in the frame_id of a batched message: each of its bodies


class BodyWrench(NamedTuple):
    """A wrench at a body's centre of mass, in body axes or in world axes."""

    in_body_axes: bool
    force: Vector  # N
    torque: Vector  # about the centre of mass, N m


class WrenchFrames:
    """The valid frames of one body.

    Parameters
    ----------
    name: name of the body.
    center_of_mass: (3,) in body coordinates, m.
    frames: further fixed frames, FRAME -> (position (3,) m, orientation (4,) x y z w) in body
        coordinates.
    """

    def __init__(
        self,
        name: str,
        center_of_mass: Sequence[float],
        frames: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    ) -> None:
        com = [float(value) for value in center_of_mass]
        identity = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        self._name = name
        # frame_id -> (rotation to body axes, lever from the centre of mass in body axes)
        self._known = {
            name: (identity, (-com[0], -com[1], -com[2])),
            f"{name}/{COM}": (identity, (0.0, 0.0, 0.0)),
        }
        for frame, (position, orientation) in frames.items():
            lever = tuple(float(p) - c for p, c in zip(position, com, strict=True))
            self._known[f"{name}/{frame}"] = (_rotation(orientation), lever)

    @property
    def frame_ids(self) -> list[str]:
        """Every valid frame_id, in the order in which error messages list them."""
        return [*self._known, WORLD]

    def resolve(self, frame_id: str, force: Vector, torque: Vector) -> BodyWrench:
        """Move a wrench from `frame_id` to the centre of mass.

        Raises UnknownFrameError, whose text lists the valid frames.
        """
        if frame_id == WORLD:
            return BodyWrench(False, force, torque)
        known = self._known.get(frame_id)
        if known is None:
            given = f"frame '{frame_id}'" if frame_id else "empty frame"
            raise UnknownFrameError(
                f"{given} refused for a wrench on body '{self._name}': "
                f"header.frame_id must be one of {', '.join(self.frame_ids)}"
            )
        rotation, lever = known
        turned_force = _apply(rotation, force)
        turned_torque = _apply(rotation, torque)
        moment = _cross(lever, turned_force)
        return BodyWrench(
            True,
            turned_force,
            (
                turned_torque[0] + moment[0],
                turned_torque[1] + moment[1],
                turned_torque[2] + moment[2],
            ),
        )


def _rotation(orientation: Sequence[float]) -> tuple[Vector, Vector, Vector]:
    x, y, z, w = (float(value) for value in orientation)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _apply(rotation: tuple[Vector, Vector, Vector], u: Vector) -> Vector:
    a, b, c = rotation
    return (
        a[0] * u[0] + a[1] * u[1] + a[2] * u[2],
        b[0] * u[0] + b[1] * u[1] + b[2] * u[2],
        c[0] * u[0] + c[1] * u[1] + c[2] * u[2],
    )


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
