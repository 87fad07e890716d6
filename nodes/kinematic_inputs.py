"""Motion of kinematic bodies, commanded by pose, by twist or by /tf.

A commanded pose is reached in uniform motion at the simulation time `header.stamp`. Where that is
over, as with a stream of poses stamped with their present, the motion takes as long as passed
between the stamps of the last two poses; a single pose is reached at the end of the next step. The
velocity of the motion is what contacts see, so a pushed object gets the right friction and impact.
A commanded twist is kept until the next command or until it expires; then the body stands still.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rb_physics import math as rotations

from .limits import not_allowed
from .refused import RefusedValueError, UnknownFrameError
from .wrench_frames import COM, WORLD
from .wrench_inputs import FOREVER, Perform

ZERO = (0.0, 0.0, 0.0)
UNIT_TOLERANCE = 1e-3  # on the norm of a commanded quaternion, as in scene files
LONGEST_GAP = 0.5  # s between two poses of a stream; after a longer one it begins anew
LONGEST_LEAD = 3600.0  # s a stamp may be ahead; the wall clock is ahead by decades


@dataclass(frozen=True)
class Motion:
    """Uniform motion: velocities in world axes until `until_step`, ending in a pose or a stop."""

    linear: NDArray[np.float64]  # of the centre of mass, m/s
    angular: NDArray[np.float64]  # rad/s
    until_step: int | None
    goal: tuple[NDArray[np.float64], NDArray[np.float64]] | None  # body frame at the end
    turning: bool = False  # velocities are given in body axes, which turn with the body
    coast: int = 0  # steps to go on behind the goal while the next pose of a stream is awaited

    def next_change(self, step: int) -> int:
        """The next step that needs a new order: the last one before a goal, or the end."""
        end = self.until_step
        assert end is not None
        return end - 1 if self.goal is not None and step < end - 1 else end + self.coast


class KinematicInputs:
    """The motions commanded now. Only the physics thread touches an object of this class."""

    def __init__(self, dt: float, timeout: float) -> None:
        self._com: dict[str, NDArray[np.float64]] = {}
        self._dt = dt
        self._motions: dict[str, Motion] = {}
        self._started: set[str] = set()
        self._stamps: dict[str, int] = {}  # ns, of the last pose of each body
        self.set_timeout(timeout)

    def fit(self, centers_of_mass: Mapping[str, Sequence[float]]) -> None:
        """The kinematic bodies; called again when bodies were added or removed."""
        self._com = {name: np.array(com, float) for name, com in centers_of_mass.items()}
        for body in [body for body in self._motions if body not in self._com]:
            del self._motions[body]
        self._started &= set(self._com)
        self._stamps = {body: stamp for body, stamp in self._stamps.items() if body in self._com}

    def set_timeout(self, timeout: float) -> None:
        """How long twists that arrive from now on are kept, s; 0 one step, -1 for ever."""
        steps = max(1, ceil(timeout / self._dt - 1e-6))
        self._hold_steps = None if timeout == FOREVER else steps

    def receive_pose(
        self, world: Any, body: str, frame_id: str, pose: Sequence[float], stamp_ns: int, step: int
    ) -> None:
        """Move `body` to `pose` (position, x y z w), stamped with simulation time.

        Raises RefusedInputError.
        """
        self._check(body, "pose", frame_id, pose, [WORLD])
        position, orientation = np.array(pose[:3]), np.array(pose[3:])
        norm = float(np.linalg.norm(orientation))
        if abs(norm - 1.0) > UNIT_TOLERANCE:
            raise RefusedValueError(
                f"pose of body '{body}' refused: the norm of its quaternion is {norm:g}, "
                f"but must be 1 within {UNIT_TOLERANCE:g}"
            )
        lead = stamp_ns * 1e-9 - world.time
        if lead > LONGEST_LEAD:
            raise RefusedValueError(
                f"pose of body '{body}' refused: its stamp is {lead:g} s ahead of the simulation's time, "
                f"and may be {LONGEST_LEAD:g} s at most; stamps are simulated time: start its sender with "
                "use_sim_time:=true, or leave the stamp 0"
            )
        steps = round(lead / self._dt)
        if steps < 1:
            steps = self._steps_since(body, stamp_ns) or 1
        self._stamps[body] = stamp_ns
        self._start(world, body, position, orientation / norm, step, steps, 0)

    def follow(
        self,
        world: Any,
        body: str,
        position: NDArray[np.float64],
        orientation: NDArray[np.float64],
        stamp_ns: int,
        step: int,
        perform: Perform,
    ) -> None:
        """The same for a pose that comes from a chain of transforms.

        The first one, and one after a long gap, only puts the body there: what has not been seen
        moving has no velocity.
        """
        if stamp_ns == self._stamps.get(body):
            return
        steps = self._steps_since(body, stamp_ns)
        self._stamps[body] = stamp_ns
        if steps is not None:
            self._start(world, body, position, orientation, step, steps, steps)
            return
        self._motions.pop(body, None)
        self._put(perform, body, position, orientation)

    def _steps_since(self, body: str, stamp_ns: int) -> int | None:
        """Steps between the last pose of a stream and this one; None: it is not of a stream."""
        gap = (stamp_ns - self._stamps.get(body, stamp_ns)) * 1e-9
        return max(1, round(gap / self._dt)) if 0.0 < gap <= LONGEST_GAP else None

    def _start(
        self,
        world: Any,
        body: str,
        position: NDArray[np.float64],
        orientation: NDArray[np.float64],
        step: int,
        steps: int,
        coast: int,
    ) -> None:
        start_position = np.array(world[body].position)
        start_orientation = np.array(world[body].orientation)
        span = steps * self._dt
        com = self._com[body]
        start_com = start_position + rotations.rotate(start_orientation, com)
        goal_com = position + rotations.rotate(orientation, com)
        backwards = start_orientation * (-1.0, -1.0, -1.0, 1.0)
        self._motions[body] = Motion(
            (goal_com - start_com) / span,
            rotations.rotation_vector(rotations.quaternion_multiply(orientation, backwards)) / span,
            step + steps,
            (position, orientation),
            coast=coast,
        )
        self._started.add(body)

    @staticmethod
    def _put(
        perform: Perform, body: str, position: NDArray[np.float64], orientation: NDArray[np.float64]
    ) -> None:
        """At rest in a pose, without having moved there."""
        perform("change_body", body=body, position=position, orientation=orientation,
                linear_velocity=ZERO, angular_velocity=ZERO)  # fmt: skip

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
        self._stamps.clear()

    def steps_unchanged(self, step: int) -> int | None:
        """For how many steps from `step` on what the last `apply` did stays right; None: for ever."""
        if any(motion.turning for motion in self._motions.values()):
            return 1
        ends = [m.next_change(step) for m in self._motions.values() if m.until_step is not None]
        return max(1, min(ends) - step) if ends else None

    def apply(self, world: Any, step: int, perform: Perform) -> None:
        """Give the kinematic bodies of `world` the motion they have in step `step`."""
        for body, motion in list(self._motions.items()):
            if motion.until_step is not None and step >= motion.until_step + motion.coast:
                if motion.goal is None:
                    perform("move", body=body, linear_velocity=ZERO, angular_velocity=ZERO)
                elif motion.coast:
                    self._put(perform, body, *motion.goal)
                del self._motions[body]
            elif motion.goal is not None and step == motion.until_step - 1:
                position, orientation = motion.goal
                velocities = (
                    {"linear_velocity": motion.linear, "angular_velocity": motion.angular}
                    if motion.coast
                    else {}
                )
                perform("move", body=body, position=position, orientation=orientation, **velocities)
            elif body in self._started or motion.turning:
                linear, angular = motion.linear, motion.angular
                if motion.turning:
                    orientation = world[body].orientation
                    linear = rotations.rotate(orientation, linear)
                    angular = rotations.rotate(orientation, angular)
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
        rule = not_allowed(values)
        if rule is not None:
            raise RefusedValueError(f"{what} of body '{body}' refused: {tuple(values)} {rule}")
