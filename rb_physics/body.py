"""A body of a world: a handle, not a copy; it stays valid when other bodies come and go."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import checks
from .errors import SceneError

if TYPE_CHECKING:
    from .world import World

Array = NDArray[np.float64]

_MATERIAL: dict[str, tuple[float | None, str]] = {  # greatest value, unit
    "friction": (None, ""),
    "static_friction": (None, ""),
    "restitution": (1.0, ""),
    "rolling_friction": (None, "m"),
    "spinning_friction": (None, "m"),
}


class Body:
    """A rigid body. Made by `World.add_body`.

    Vectors are world axes and SI units. ``position`` and ``orientation`` are those of the body
    frame, the coordinates in which the shape is given; velocities are those of the centre of mass.
    Arrays are copies that can't be written to: assign a whole one, ``body.position = (0, 0, 1)``.
    """

    __slots__ = ("__weakref__", "_frames", "_name", "_row", "_shape", "_type", "_world")

    def __init__(
        self,
        world: World,
        row: int,
        name: str,
        type: str,
        shape: Any,
        frames: dict[str, tuple[Array, Array]],
    ) -> None:
        self._world: World | None = world
        self._row = row
        self._name = name
        self._type = type
        self._shape = shape
        self._frames = MappingProxyType(frames)

    def __setattr__(self, name: str, value: Any) -> None:
        checks.settable(self, name, "a body keeps it for life; remove the body and add another")
        super().__setattr__(name, value)

    @property
    def name(self) -> str:
        """Unique in its world."""
        return self._name

    @property
    def type(self) -> str:
        """ "dynamic", "static" or "kinematic"."""
        return self._type

    @property
    def shape(self) -> Any:
        """In body coordinates."""
        return self._shape

    @property
    def frames(self) -> Mapping[str, tuple[Array, Array]]:
        """Further fixed frames: name -> (position (3,) m, orientation (4,)), body coordinates."""
        return self._frames

    def __repr__(self) -> str:
        return f"<Body {self.name!r}: {self.type}, {self.shape!r}>"

    @property
    def row(self) -> int:
        """Row in the arrays of the world. Moves up when an earlier body is removed."""
        self._core()
        return self._row

    @property
    def world(self) -> World:
        """The world it is in. Raises `SceneError` when it was removed."""
        return self._core()

    def _core(self) -> World:
        if self._world is None:
            raise SceneError(f"body {self.name!r} was removed from its world", body=self.name)
        return self._world

    # ---- state ----------------------------------------------------------------------------
    @property
    def position(self) -> Array:
        """(3,) m, origin of the body frame. Setting it keeps the velocities."""
        return self._core()._position(self._row)

    @position.setter
    def position(self, value: ArrayLike) -> None:
        position = checks.vector(self.name, "position", value, unit="m")
        self._core()._set_pose(self._row, position, self.orientation)

    @property
    def orientation(self) -> Array:
        """(4,) unit quaternion x y z w, body to world. Setting it keeps position and velocities."""
        return self._core()._orientation(self._row)

    @orientation.setter
    def orientation(self, value: ArrayLike) -> None:
        q = checks.quaternion(self.name, "orientation", value)
        self._core()._set_pose(self._row, self.position, q)

    @property
    def com_position(self) -> Array:
        """(3,) m, centre of mass. Setting it moves the body without turning it."""
        return self._core()._com_position(self._row)

    @com_position.setter
    def com_position(self, value: ArrayLike) -> None:
        com = checks.vector(self.name, "com_position", value, unit="m")
        self.position = self.position + (com - self.com_position)

    @property
    def linear_velocity(self) -> Array:
        """(3,) m/s, of the centre of mass."""
        return self._core()._linear_velocity(self._row)

    @linear_velocity.setter
    def linear_velocity(self, value: ArrayLike) -> None:
        self._not_static("linear_velocity")
        v = checks.vector(self.name, "linear_velocity", value, unit="m/s")
        self._core()._set_linear_velocity(self._row, v)

    @property
    def angular_velocity(self) -> Array:
        """(3,) rad/s."""
        return self._core()._angular_velocity(self._row)

    @angular_velocity.setter
    def angular_velocity(self, value: ArrayLike) -> None:
        self._not_static("angular_velocity")
        w = checks.vector(self.name, "angular_velocity", value, unit="rad/s")
        self._core()._set_angular_velocity(self._row, w)

    @property
    def asleep(self) -> bool:
        """At rest and not computed until something happens to it (`Settings.sleeping`)."""
        return self._core()._asleep(self._row) and self.type == "dynamic"

    # ---- properties of matter ---------------------------------------------------------------
    @property
    def mass(self) -> float:
        """kg; 0 for static and kinematic bodies."""
        return self._core()._mass_properties(self._row)[0]

    @property
    def center_of_mass(self) -> Array:
        """(3,) m, in body coordinates."""
        return self._core()._mass_properties(self._row)[1]

    @property
    def inertia(self) -> Array:
        """(3, 3) kg m², body axes, about the centre of mass; zero where nothing turns (S4)."""
        return self._core()._mass_properties(self._row)[2]

    @property
    def friction(self) -> float:
        """Kinetic coefficient of Coulomb friction, ≥ 0. Settable."""
        return self._core()._material(self._row).friction

    @friction.setter
    def friction(self, value: float) -> None:
        self.set_material(friction=value)

    @property
    def static_friction(self) -> float:
        """Coefficient while sticking, ≥ friction. Settable."""
        return self._core()._material(self._row).static_friction

    @static_friction.setter
    def static_friction(self, value: float) -> None:
        self.set_material(static_friction=value)

    @property
    def restitution(self) -> float:
        """Coefficient of restitution in [0, 1]. Settable."""
        return self._core()._material(self._row).restitution

    @restitution.setter
    def restitution(self, value: float) -> None:
        self.set_material(restitution=value)

    @property
    def rolling_friction(self) -> float:
        """m: bound on rolling moment over normal force, ≥ 0. Settable."""
        return self._core()._material(self._row).rolling_friction

    @rolling_friction.setter
    def rolling_friction(self, value: float) -> None:
        self.set_material(rolling_friction=value)

    @property
    def spinning_friction(self) -> float:
        """m: bound on spinning moment over normal force, ≥ 0. Settable."""
        return self._core()._material(self._row).spinning_friction

    @spinning_friction.setter
    def spinning_friction(self, value: float) -> None:
        self.set_material(spinning_friction=value)

    @property
    def layer(self) -> int:
        """32 bits: the collision layers the body is in."""
        return self._core()._filter(self._row).layer

    @property
    def mask(self) -> int:
        """32 bits: the layers whose bodies it may touch, if they may touch its own."""
        return self._core()._filter(self._row).mask

    def set_material(self, **values: float) -> None:
        """Sets several of the coefficients above at once. Raises `SceneError`; then none is set."""
        core = self._core()
        material = core._material(self._row)
        follows = material.static_friction == material.friction
        for field, value in values.items():
            if field not in _MATERIAL:
                raise SceneError(
                    f"body {self.name!r}: unknown property of a surface {field!r}"
                    f"{checks.suggestion(field, _MATERIAL)}",
                    body=self.name,
                    field=field,
                )
            most, unit = _MATERIAL[field]
            number = checks.number(self.name, field, value, 0.0, most, unit=unit)
            setattr(material, field, number)
        if "friction" in values and follows and "static_friction" not in values:
            material.static_friction = material.friction
        if material.static_friction < material.friction:
            raise SceneError.about(
                self.name,
                "static_friction",
                material.static_friction,
                f"≥ friction ({material.friction:g})",
            )
        core._set_material(self._row, material)

    # ---- forces -----------------------------------------------------------------------------
    @property
    def contact_wrench(self) -> Array:
        """(2, 3): contact force (N) and torque about the centre of mass (N m), world axes, mean over
        the last step."""
        return self._core()._contact_wrench(self._row)

    def apply_wrench(
        self,
        force: ArrayLike = (0.0, 0.0, 0.0),
        torque: ArrayLike = (0.0, 0.0, 0.0),
        point: ArrayLike | None = None,
        frame: str = "world",
        duration: float | None = None,
        *,
        source: int = 0,
    ) -> None:
        """Applies a force and a torque from the next step on.

        Args:
            force: (3,) N, axes of ``frame``.
            torque: (3,) N m, axes of ``frame``.
            point: (3,) m, where the force acts, in coordinates of ``frame``; it stays fixed to the
                body. None: the centre of mass.
            frame: "world": keeps its direction; "body": turns with the body.
            duration: s of sim time; None: until replaced or cleared; 0: one step. The impulse is
                force times duration whatever dt is.
            source: a whole number ≥ 0; a second wrench of the same source replaces the first;
                sources add up.

        Raises:
            SceneError: wrong sizes, NaN or infinity, unknown frame, negative duration, not dynamic.
        """
        self._dynamic("apply_wrench")
        checks.choice(self.name, "frame", frame, ("world", "body"))
        if duration is not None:
            checks.number(self.name, "duration", duration, 0.0, unit="s")
        self._core()._apply_wrench(
            self._row,
            checks.whole_number("source", source, 0),
            checks.vector(self.name, "force", force, unit="N"),
            checks.vector(self.name, "torque", torque, unit="N m"),
            None if point is None else checks.vector(self.name, "point", point, unit="m"),
            frame == "body",
            -1.0 if duration is None else float(duration),
        )

    def clear_wrenches(self, source: int | None = None) -> None:
        """Ends the applied wrenches, all or those of one source."""
        number = -1 if source is None else checks.whole_number("source", source, 0)
        self._core()._clear_wrenches(self._row, number)

    def apply_impulse(self, impulse: ArrayLike, point: ArrayLike | None = None) -> None:
        """Changes the momentum at once: impulse (3,) N s at the world point (3,) m, or at the centre
        of mass."""
        self._dynamic("apply_impulse")
        self._core()._apply_impulse(
            self._row,
            checks.vector(self.name, "impulse", impulse, unit="N s"),
            None if point is None else checks.vector(self.name, "point", point, unit="m"),
        )

    def move(
        self,
        position: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        linear_velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
    ) -> None:
        """Drives a kinematic body.

        With a pose (either part; the other stays): the body is there at the end of the next step,
        and contacts feel the velocity that takes it there; it then stands still. With velocities
        only: it moves with them until told otherwise. With both: it is at the pose at the end of the
        next step, contacts feel the given velocities, and it goes on with them.

        Raises:
            SceneError: the body is not kinematic, wrong sizes, NaN or infinity.
        """
        core = self._core()
        if self.type != "kinematic":
            raise SceneError(
                f"body {self.name!r} is {self.type}; only kinematic bodies can be moved",
                body=self.name,
            )
        has_twist = linear_velocity is not None or angular_velocity is not None
        if has_twist:
            v = self.linear_velocity if linear_velocity is None else linear_velocity
            w = self.angular_velocity if angular_velocity is None else angular_velocity
            v = checks.vector(self.name, "linear_velocity", v, unit="m/s")
            w = checks.vector(self.name, "angular_velocity", w, unit="rad/s")
        if position is not None or orientation is not None:
            x = self.position if position is None else position
            q = self.orientation if orientation is None else orientation
            x = checks.vector(self.name, "position", x, unit="m")
            q = checks.quaternion(self.name, "orientation", q)
            core._set_target(self._row, x, q, not has_twist)
        if has_twist:
            core._set_linear_velocity(self._row, v)
            core._set_angular_velocity(self._row, w)

    def _dynamic(self, what: str) -> None:
        if self.type != "dynamic":
            raise SceneError(
                f"body {self.name!r} is {self.type}; {what} needs a dynamic body", body=self.name
            )

    def _not_static(self, field: str) -> None:
        if self.type == "static":
            raise SceneError(
                f"body {self.name!r} is static; {field} can't be set", body=self.name, field=field
            )
