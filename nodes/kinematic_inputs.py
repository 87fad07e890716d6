"""Motion of kinematic bodies, commanded by pose or by twist.

A commanded pose is reached in uniform motion at the simulation time `header.stamp`; a stamp at or
before the present means the end of the next step. The velocity of that motion is what contacts
see, so a pushed object gets the right friction and impact. A commanded twist is kept until the
next command or until it expires; then the body stands still.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .refused import RefusedValueError, UnknownFrameError
from .wrench_frames import COM, WORLD
from .wrench_inputs import FOREVER, Perform

ZERO = (0.0, 0.0, 0.0)
UNIT_TOLERANCE = 1e-3  # on the norm of a commanded quaternion, as in scene files


@dataclass(frozen=True)
class Motion:
    """Uniform motion: velocities in world axes until `until_step`, ending in a pose or a stop."""

    linear: NDArray[np.float64]  # of the centre of mass, m/s
    angular: NDArray[np.float64]  # rad/s
    until_step: int | None
    goal: tuple[NDArray[np.float64], NDArray[np.float64]] | None  # body frame at the end
    turning: bool = False  # velocities are given in body axes, which turn with the body

    def next_change(self, step: int) -> int:
        """The next step that needs a new order: the last one before a goal, or the end."""
        end = self.until_step
        assert end is not None
        return end - 1 if self.goal is not None and step < end - 1 else end


class KinematicInputs:
    """The motions commanded now. Only the physics thread touches an object of this class."""

    def __init__(self, centers_of_mass: Mapping[str, Sequence[float]], dt: float, timeout: float):
        self._com = {name: np.array(com, float) for name, com in centers_of_mass.items()}
        self._dt = dt
        self._motions: dict[str, Motion] = {}
        self._started: set[str] = set()
        self.set_timeout(timeout)

    def set_timeout(self, timeout: float) -> None:
        """How long twists that arrive from now on are kept, s; 0 one step, -1 for ever."""
        steps = max(1, math.ceil(timeout / self._dt - 1e-6))
        self._hold_steps = None if timeout == FOREVER else steps

    def receive_pose(
        self, world: Any, body: str, frame_id: str, pose: Sequence[float], time: float, step: int
    ) -> None:
        """Move `body` to `pose` (position, x y z w) by the simulation time `time`.

        Raises RefusedInputError.
        """
        self._check(body, "pose", frame_id, pose, [WORLD])
        position, orientation = np.array(pose[:3]), np.array(pose[3:])
        norm = math.sqrt(float(orientation @ orientation))
        if abs(norm - 1.0) > UNIT_TOLERANCE:
            raise RefusedValueError(
                f"pose of body '{body}' refused: the norm of its quaternion is {norm:g}, "
                f"but must be 1 within {UNIT_TOLERANCE:g}"
            )
        orientation /= norm
        steps = max(1, round((time - world.time) / self._dt))
        start_position = np.array(world[body].position)
        start_orientation = np.array(world[body].orientation)
        span = steps * self._dt
        com = self._com[body]
        start_com = start_position + rotate(start_orientation, com)
        goal_com = position + rotate(orientation, com)
        self._motions[body] = Motion(
            (goal_com - start_com) / span,
            rotation_vector(start_orientation, orientation) / span,
            step + steps,
            (position, orientation),
        )
        self._started.add(body)

    def receive_twist(self, body: str, frame_id: str, twist: Sequence[float], step: int) -> None:
        """Move `body` with `twist` (linear m/s, angular rad/s) of the origin of `frame_id`.

        Raises RefusedInputError.
        """
        frames = [body, f"{body}/{COM}", WORLD]
        self._check(body, "twist", frame_id, twist, frames)
        linear, angular = np.array(twist[:3]), np.array(twist[3:])
        if frame_id == body:
            linear = linear + np.cross(angular, self._com[body])
        until = None if self._hold_steps is None else step + self._hold_steps
        self._motions[body] = Motion(linear, angular, until, None, turning=frame_id != WORLD)
        self._started.add(body)

    def clear(self, perform: Perform) -> None:
        """Stop every commanded body where it is."""
        for body in self._motions:
            perform("move", body=body, linear_velocity=ZERO, angular_velocity=ZERO)
        self._motions.clear()
        self._started.clear()

    def steps_unchanged(self, step: int) -> int | None:
        """For how many steps from `step` on what the last `apply` did stays right; None: for ever."""
        if any(motion.turning for motion in self._motions.values()):
            return 1
        ends = [m.next_change(step) for m in self._motions.values() if m.until_step is not None]
        return max(1, min(ends) - step) if ends else None

    def apply(self, world: Any, step: int, perform: Perform) -> None:
        """Give the kinematic bodies of `world` the motion they have in step `step`."""
        for body, motion in list(self._motions.items()):
            if motion.until_step is not None and step >= motion.until_step:
                if motion.goal is None:
                    perform("move", body=body, linear_velocity=ZERO, angular_velocity=ZERO)
                del self._motions[body]
            elif motion.goal is not None and step == motion.until_step - 1:
                position, orientation = motion.goal
                perform("move", body=body, position=position, orientation=orientation)
            elif body in self._started or motion.turning:
                linear, angular = motion.linear, motion.angular
                if motion.turning:
                    orientation = world[body].orientation
                    linear, angular = rotate(orientation, linear), rotate(orientation, angular)
                perform("move", body=body, linear_velocity=linear, angular_velocity=angular)
        self._started.clear()

    def _check(
        self, body: str, what: str, frame_id: str, values: Sequence[float], frames: list[str]
    ) -> None:
        if frame_id not in frames:
            given = f"frame '{frame_id}'" if frame_id else "empty frame"
            raise UnknownFrameError(
                f"{given} refused for a {what} of body '{body}': "
                f"header.frame_id must be one of {', '.join(frames)}"
            )
        if not all(map(math.isfinite, values)):
            raise RefusedValueError(
                f"{what} of body '{body}' refused: {tuple(values)} must be finite"
            )


def rotation_vector(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation (axis times angle <= π, world axes, rad) that takes `start` to `end`."""
    difference = _multiply(end, start * np.array([-1.0, -1.0, -1.0, 1.0]))
    if difference[3] < 0.0:
        difference = -difference
    sine = math.sqrt(float(difference[:3] @ difference[:3]))
    if sine < 1e-12:
        return 2.0 * difference[:3]
    return difference[:3] * (2.0 * math.atan2(sine, difference[3]) / sine)


def rotate(orientation: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
    """`u` turned by the unit quaternion `orientation` (x, y, z, w)."""
    cross = np.cross(orientation[:3], u)
    return u + 2.0 * (orientation[3] * cross + np.cross(orientation[:3], cross))


def _multiply(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    vector = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.array([*vector, a[3] * b[3] - a[:3] @ b[:3]])
