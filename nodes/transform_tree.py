"""Transforms as they come on /tf and /tf_static, and poses in the world composed from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rb_physics import math as rotations

from .kinematic_inputs import UNIT_TOLERANCE
from .refused import RefusedValueError, UnknownFrameError
from .wrench_frames import WORLD

Transform = tuple[int, str, str, tuple[float, ...]]  # stamp ns, frame, child frame, 7 doubles
DEEPEST = 256  # transforms between a link and the world; more is taken for a loop


class TransformTree:
    """The last transform of each child frame."""

    def __init__(self) -> None:
        # child -> (parent, translation, rotation, stamp in ns; 0 where it is fixed)
        self._parents: dict[str, tuple[str, NDArray[np.float64], NDArray[np.float64], int]] = {}

    def update(self, transforms: Sequence[Transform], topic: str, static: bool) -> None:
        """Take in a message. Raises RefusedValueError: then nothing of it is kept."""
        taken = {}
        for stamp, parent, child, values in transforms:
            if not all(map(math.isfinite, values)):
                raise RefusedValueError(
                    f"message on {topic} refused: the transform of '{child}' is {values}; it must "
                    "be finite"
                )
            rotation = np.array(values[3:])
            norm = math.sqrt(float(rotation @ rotation))
            if abs(norm - 1.0) > UNIT_TOLERANCE:
                raise RefusedValueError(
                    f"message on {topic} refused: the norm of the quaternion of '{child}' is "
                    f"{norm:g}, but must be 1 within {UNIT_TOLERANCE:g}"
                )
            moment = 0 if static else stamp
            taken[child.strip("/")] = (
                parent.strip("/"), np.array(values[:3]), rotation / norm, moment
            )  # fmt: skip
        self._parents.update(taken)

    def pose(self, frame: str) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        """(position, orientation, newest stamp in ns) of `frame` in the world.

        Raises UnknownFrameError when no chain of transforms leads there.
        """
        position, orientation, newest = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0
        at = frame
        for _ in range(DEEPEST):
            if at == WORLD:
                return position, orientation, newest
            if at not in self._parents:
                raise UnknownFrameError(
                    f"the pose of frame '{frame}' is not known: no transform leads from '{at}' to "
                    f"'{WORLD}'"
                )
            at, translation, rotation, stamp = self._parents[at]
            position = translation + rotations.rotate(rotation, position)
            orientation = rotations.quaternion_multiply(rotation, orientation)
            newest = max(newest, stamp)
        raise UnknownFrameError(f"the transforms of frame '{frame}' go in a circle")

    def clear(self) -> None:
        """Time went back: only fixed transforms stay."""
        self._parents = {c: p for c, p in self._parents.items() if p[3] == 0}
