"""The world: bodies, time, contacts. Rows of all arrays are in the order of adding."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, checks
from .body import Body
from .errors import SceneError
from .mass_properties import mass_properties
from .settings import Settings

Array = NDArray[np.float64]

_TYPES = {
    "dynamic": _core.BodyType.DYNAMIC,
    "static": _core.BodyType.STATIC,
    "kinematic": _core.BodyType.KINEMATIC,
}
_SHAPES = (
    _core.Particle,
    _core.Sphere,
    _core.Box,
    _core.Capsule,
    _core.Cylinder,
    _core.HalfSpace,
    _core.ConvexHull,
    _core.TriangleMesh,
    _core.HeightField,
    _core.Compound,
)


class RayHit(NamedTuple):
    """What a ray meets first."""

    body: Body
    distance: float
    """m from the origin of the ray."""
    point: Array
    """(3,) m."""
    normal: Array
    """(3,) unit, out of the body."""


class World(_core.World):
    """Rigid bodies in contact.

    Example::

        world = rb.World(gravity=(0, 0, -9.81), dt=1e-3)
        world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", name="ground")
        box = world.add_body(rb.Box(half_extents=(.1, .1, .1)), mass=1.0, position=(0, 0, 1))
        world.step(1000)

    Args:
        settings: all choices at once; keywords replace single ones.
        **keywords: any field of `Settings`.

    Raises:
        SceneError: an unknown setting or a value that is not allowed.
    """

    __slots__ = ("_bodies", "_by_name", "_chosen")

    def __init__(self, settings: Settings | None = None, **keywords: Any) -> None:
        self._chosen = Settings.from_keywords(settings, keywords)
        super().__init__(self._chosen.to_core())
        self._bodies: list[Body] = []
        self._by_name: dict[str, Body] = {}

    def __setattr__(self, name: str, value: Any) -> None:
        checks.settable(self, name, "settings hold for life, state is set through the bodies")
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        return f"<World: {len(self._bodies)} bodies, t = {self.time:.6g} s>"

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies, in the order of rows."""
        return tuple(self._bodies)

    @property
    def settings(self) -> Settings:
        """All choices about the physics, for the life of the world."""
        return self._chosen

    @property
    def dt(self) -> float:
        """s, length of a step."""
        return self.settings.dt

    @property
    def gravity(self) -> Array:
        """(3,) m/s², world axes. Not to be written to."""
        gravity = np.array(self.settings.gravity)
        gravity.flags.writeable = False
        return gravity

    def __getitem__(self, name: str) -> Body:
        """The body of that name. Raises KeyError that lists the names."""
        if isinstance(name, str) and name in self._by_name:
            return self._by_name[name]
        known = ", ".join(self._by_name) or "none"
        row = "" if isinstance(name, str) else " (by row: world.bodies[row])"
        raise KeyError(f"no body is named {name!r}; bodies: {known}{row}")

    def __contains__(self, body: object) -> bool:
        """Whether a body, or a body of that name, is in this world."""
        if isinstance(body, Body):
            return body._world is self
        return isinstance(body, str) and body in self._by_name

    def __len__(self) -> int:
        return len(self._bodies)

    def add_body(
        self,
        shape: Any,
        *,
        type: str = "dynamic",
        name: str | None = None,
        mass: float | None = None,
        density: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (0.0, 0.0, 0.0, 1.0),
        inertia: ArrayLike | None = None,
        center_of_mass: ArrayLike | None = None,
        linear_velocity: ArrayLike = (0.0, 0.0, 0.0),
        angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
        friction: float = 0.5,
        restitution: float = 0.0,
        static_friction: float | None = None,
        rolling_friction: float = 0.0,
        spinning_friction: float = 0.0,
        layer: int = 1,
        mask: int = 0xFFFFFFFF,
        frames: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
        **unknown: Never,
    ) -> Body:
        """Adds a body and returns its handle.

        Args:
            shape: in body coordinates: `Sphere`, `Box`, `Compound`, ...
            type: "dynamic", "static" or "kinematic" (moves as told, pushes with infinite mass).
            name: unique; a letter, then letters, digits, underscores. None: "body_N".
            mass: kg; density: kg/m³. A dynamic body needs exactly one of them.
            position, orientation: of the body frame; (3,) m, (4,) unit quaternion x y z w.
            inertia: (3,) principal moments or (3, 3), kg m², body axes, about the centre of mass.
                None: the shape's, scaled to the mass.
            center_of_mass: (3,) m, body coordinates. None: the shape's.
            linear_velocity, angular_velocity: (3,) m/s of the centre of mass, (3,) rad/s; world axes.
            friction, static_friction: Coulomb coefficients, 0 ≤ friction ≤ static_friction (None:
                the same).
            restitution: in [0, 1].
            rolling_friction, spinning_friction: m, ≥ 0.
            layer, mask: 32 bits each. Two bodies touch only if each one's mask has a bit of the
                other's layer.
            frames: further fixed frames: name -> (position (3,), orientation (4,)).

        Raises:
            SceneError: names the body, the field, the value and what is allowed.
        """
        for field in unknown:
            raise SceneError(
                f"add_body has no argument {field!r}"
                f"{checks.suggestion(field, World.add_body.__kwdefaults__ or ())}",
                field=field,
            )
        if name is None:
            index = len(self._bodies)
            while f"body_{index}" in self._by_name:
                index += 1
            name = f"body_{index}"
        checks.name(name, "body", self._by_name)
        checks.choice(name, "type", type, _TYPES)
        if not isinstance(shape, _SHAPES):
            known = ", ".join(s.__name__ for s in _SHAPES)
            raise SceneError.about(name, "shape", shape, f"a shape ({known})")
        material = _core.Material()
        material.friction = checks.number(name, "friction", friction, 0.0)
        if static_friction is None:
            static_friction = friction
        material.static_friction = checks.number(name, "static_friction", static_friction, 0.0)
        if material.static_friction < material.friction:
            raise SceneError.about(
                name, "static_friction", static_friction, f"≥ friction ({friction:g})"
            )
        material.rolling_friction = checks.number(
            name, "rolling_friction", rolling_friction, 0.0, unit="m"
        )
        material.spinning_friction = checks.number(
            name, "spinning_friction", spinning_friction, 0.0, unit="m"
        )
        material.restitution = checks.number(name, "restitution", restitution, 0.0, 1.0)
        x = checks.vector(name, "position", position, unit="m")
        q = checks.quaternion(name, "orientation", orientation)
        v = checks.vector(name, "linear_velocity", linear_velocity, unit="m/s")
        w = checks.vector(name, "angular_velocity", angular_velocity, unit="rad/s")
        particle = isinstance(shape, _core.Particle)
        if type == "static" and (v.any() or w.any()):
            field = "linear_velocity" if v.any() else "angular_velocity"
            raise SceneError(
                f"body {name!r} is static; {field} must be zero", body=name, field=field
            )
        if particle and w.any():
            raise SceneError(
                f"body {name!r} is a particle and does not rotate; angular_velocity must be zero",
                body=name,
                field="angular_velocity",
            )
        collide = _core.CollisionFilter(
            checks.whole_number("layer", layer, 0, 0xFFFFFFFF, body=name),
            checks.whole_number("mask", mask, 0, 0xFFFFFFFF, body=name),
        )
        total, com, moments = mass_properties(
            name, shape, type, mass, density, inertia, center_of_mass
        )
        if particle and type != "dynamic":
            raise SceneError.about(
                name, "shape", shape, f"a shape with a surface for a {type} body"
            )
        parsed = _frames(name, frames)
        row = self._add(
            shape, name, _TYPES[type], total, com, moments, x, q, v, w, material, collide, particle
        )
        body = Body(self, row, name, type, shape, parsed)
        self._bodies.append(body)
        self._by_name[name] = body
        return body

    def copy(self, **settings: Any) -> World:
        """An independent world of the same bodies in the same state, which goes on with the same bits.

        Args:
            **settings: single fields of `Settings` that are to differ; `dt` and `sleeping` should stay.

        Raises:
            SceneError: an unknown setting or a value that is not allowed.
        """
        twin = World(Settings.from_keywords(self.settings, settings))
        for body in self._bodies:
            core = self._mass_properties(body._row)
            row = twin._add(
                body.shape,
                body.name,
                _TYPES[body.type],
                *core,
                body.position,
                body.orientation,
                np.zeros(3),
                np.zeros(3),
                self._material(body._row),
                self._filter(body._row),
                isinstance(body.shape, _core.Particle),
            )
            handle = Body(twin, row, body.name, body.type, body.shape, dict(body.frames))
            twin._bodies.append(handle)
            twin._by_name[body.name] = handle
        twin.restore(self.save())
        return twin

    def ray_cast(self, origin: ArrayLike, direction: ArrayLike) -> RayHit | None:
        """The nearest body along the ray from ``origin`` (3,) m in ``direction`` (3,), or None.

        Raises:
            SceneError: NaN or infinity, wrong shapes, a direction of length 0.
        """
        start = checks.vector(None, "origin", origin, unit="m")
        along = checks.vector(None, "direction", direction)
        if not along.any():
            raise SceneError.about(None, "direction", direction, "not the zero vector")
        longest = float(np.abs(along).max())
        if not 1e-100 < longest < 1e100:  # its square would vanish or overflow
            along /= longest
        hit = self._ray_cast(start, along)
        if hit is None:
            return None
        row, distance, point, normal = hit
        return RayHit(self._bodies[row], distance, point, normal)

    def restore(self, snapshot: bytes) -> None:
        """Takes back the state of a `save` of this world or of one built the same way.

        Raises:
            SceneError: the bytes are not a snapshot, or one of another world; nothing has changed.
        """
        if not isinstance(snapshot, (bytes, bytearray, memoryview)):
            raise SceneError.about(None, "snapshot", snapshot, "the bytes that `save` returned")
        try:
            super().restore(bytes(snapshot))
        except ValueError as error:
            raise SceneError(str(error), field="snapshot") from None

    def remove(self, body: Body) -> None:
        """Takes the body out; later rows move up. Raises `SceneError` when it is not in this world."""
        if not isinstance(body, Body):
            raise SceneError.about(None, "body", body, "a body of this world: world['NAME']")
        if body._world is not self:
            raise SceneError(f"body {body.name!r} is not in this world", body=body.name)
        self._remove(body._row)
        del self._bodies[body._row]
        del self._by_name[body.name]
        body._world = None
        for row, other in enumerate(self._bodies):
            other._row = row


def _frames(
    body: str, frames: Mapping[str, tuple[ArrayLike, ArrayLike]] | None
) -> dict[str, tuple[Array, Array]]:
    if frames is None:
        return {}
    if not isinstance(frames, Mapping):
        raise SceneError.about(
            body, "frames", frames, "a dict: frame name -> (position, orientation)"
        )
    parsed: dict[str, tuple[Array, Array]] = {}
    for key, value in frames.items():
        checks.name(key, "frame", parsed, body)
        if key == "com":
            raise SceneError(
                f"body {body!r}: frame name 'com' is taken by the centre of mass", body=body
            )
        try:
            position, orientation = value
        except (TypeError, ValueError):
            raise SceneError.about(
                body, f"frames.{key}", value, "(position, orientation)"
            ) from None
        pose = (
            checks.vector(body, f"frames.{key}.position", position, unit="m"),
            checks.quaternion(body, f"frames.{key}.orientation", orientation),
        )
        for array in pose:
            array.flags.writeable = False
        parsed[key] = pose
    return parsed
