"""Poses of the frames of a world: `world`, NAME, NAME/com, NAME/FRAME."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rb_physics import math as rotations

from .wrench_frames import COM, WORLD

Pose = tuple[NDArray[np.float64], NDArray[np.float64]]  # position (3,) m, orientation (4,) x y z w


def frame_pose(world: Any, frame_id: str) -> Pose:
    """Where a frame is now; an empty one means the world. Raises ValueError that lists the frames."""
    identity = np.array([0.0, 0.0, 0.0, 1.0])
    if frame_id in ("", WORLD):
        return np.zeros(3), identity
    name, _, part = frame_id.partition("/")
    if name in world:
        body = world[name]
        at = np.array(body.position), np.array(body.orientation)
        if not part:
            return at
        if part == COM:
            return compose(at, (np.array(body.center_of_mass), identity))
        if part in body.frames:
            return compose(at, body.frames[part])
    known = ", ".join([WORLD, *(body.name for body in world.bodies)])
    raise ValueError(
        f"there is no frame '{frame_id}'; there are {known}, and NAME/{COM} and NAME/FRAME of each"
    )


def compose(a: Pose, b: Pose) -> Pose:
    """The pose in the world of what has the pose `b` in a frame whose own pose is `a`."""
    return a[0] + rotations.rotate(a[1], np.asarray(b[0])), rotations.quaternion_multiply(
        a[1], np.asarray(b[1])
    )
