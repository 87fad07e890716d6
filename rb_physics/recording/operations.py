"""Every way a world is changed from outside, as data: what a repetition of a run needs.

An operation is a name and plain arguments (numbers, text, lists), logged as JSON with the number
of steps made before it; floating-point numbers keep all their bits. Arguments are those of the
method of the same name in the Python face, with the body's name as `body`:

=================  =================================================================
apply_wrench       body, force, torque, point, frame, duration, source
clear_wrenches     body (None: all bodies), source (None: all)
apply_impulse      body, impulse, point
move               body, position, orientation, linear_velocity, angular_velocity
set_state          body and any of the four of move: sets the state of any body
change_body        body and any of the four of move and of friction, static_friction,
                   restitution, rolling_friction, spinning_friction: all of it or nothing
apply_wrenches     bodies, sources, wrenches (a row of force and torque at the centre of mass
                   for each), frame, duration: apply_wrench for many bodies
add_body           description: a body as in a scene file
remove_body        body
reset              back to the state and time at the start of the recording, bodies included
reset_state        back to that state; time goes on
reset_time         back to time 0; the state stays
=================  =================================================================

Both resets take keep_spawned (False): bodies added since stay, in the state they were added in.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .initial_bodies import InitialBodies

CHANGE_BODIES = ("add_body", "remove_body", "reset", "reset_state")  # the set of bodies may change
MOVE_BODIES = (*CHANGE_BODIES, "set_state", "change_body", "restore")  # at once, between two steps
RESETS = ("reset", "reset_state", "reset_time", "restore")  # time or state jumps
_GREATEST = 1e20  # m, m/s, rad/s; a state with more can't be stepped
_STATE = ("position", "orientation", "linear_velocity", "angular_velocity")


class Operation(NamedTuple):
    """One logged change of the world."""

    step: int  # steps made since the start of the recording; it takes effect in the next one
    name: str
    arguments: dict[str, Any]


class Operations:
    """Performs operations on one world."""

    def __init__(self, world: Any, initial: bytes | None = None) -> None:
        """`initial`: the snapshot that `reset` goes back to; None: the present state."""
        self._world = world
        self._initial: bytes = world.save() if initial is None else initial
        self._first_bodies = InitialBodies(world)
        self._spawned: dict[str, dict[str, Any]] = {}  # description by name, in order

    def perform(self, name: str, arguments: Mapping[str, Any]) -> None:
        """Raises ValueError for an unknown operation, and what the world raises."""
        method: Callable[..., None] | None = _METHODS.get(name)
        if method is None:
            raise ValueError(f"unknown operation {name!r}; known are {', '.join(_METHODS)}")
        method(self, **arguments)

    def _apply_wrench(self, body: str, **arguments: Any) -> None:
        self._world[body].apply_wrench(**arguments)

    def _clear_wrenches(self, body: str | None = None, source: int | None = None) -> None:
        for each in self._world.bodies if body is None else [self._world[body]]:
            each.clear_wrenches(source=source)

    def _apply_impulse(self, body: str, **arguments: Any) -> None:
        self._world[body].apply_impulse(**arguments)

    def _move(self, body: str, **arguments: Any) -> None:
        self._world[body].move(**arguments)

    def _apply_wrenches(
        self,
        bodies: list[str],
        sources: list[int],
        wrenches: list[list[float]],
        frame: str,
        duration: float | None,
    ) -> None:
        rows = []
        for name in bodies:
            if self._world[name].type != "dynamic":
                raise ValueError(f"body '{name}' is {self._world[name].type}, not dynamic")
            rows.append(self._world[name].row)
        values = np.array(wrenches, np.float64).reshape(len(rows), 6)
        if not np.isfinite(values).all():
            raise ValueError("every wrench must be finite")
        held = -1.0 if duration is None else float(duration)
        self._world._apply_wrenches(rows, sources, values, frame == "body", held)

    def _change_body(self, body: str, **arguments: Any) -> None:
        from .. import checks

        target = self._world[body]
        given = {key: value for key, value in arguments.items() if value is not None}
        state = {key: given.pop(key) for key in _STATE if key in given}
        for key, value in state.items():
            (checks.quaternion if key == "orientation" else checks.vector)(body, key, value)
            if max(map(abs, value)) > _GREATEST:
                raise checks.SceneError.about(body, key, value, f"{_GREATEST:g} at most")
            if key.endswith("velocity") and target.type == "static":
                target._not_static(key)
        if given:
            target.set_material(**given)
        for key, value in state.items():
            setattr(target, key, value)

    @property
    def descriptions(self) -> dict[str, dict[str, Any]]:
        """Of the bodies added since the start, by name in their order."""
        return dict(self._spawned)

    @property
    def spawned(self) -> tuple[str, ...]:
        """Names of the bodies added since the start, in their order."""
        return tuple(self._spawned)

    def _add_body(self, description: dict[str, Any]) -> None:
        from ..scene import add_body

        body = add_body(self._world, description)
        self._spawned[body.name] = description

    def _remove_body(self, body: str) -> None:
        self._world.remove(self._world[body])
        self._spawned.pop(body, None)

    def _reset(self, keep_spawned: bool = False) -> None:
        self._first_bodies.put_back()
        self._world.restore(self._initial)
        spawned, self._spawned = self._spawned, {}
        if keep_spawned:
            for name, description in spawned.items():
                if name not in self._world:  # a removed body of the start had that name and is back
                    self._add_body(description)

    def _reset_time(self) -> None:
        self._world.step_count = 0

    def _reset_state(self, keep_spawned: bool = False) -> None:
        steps = self._world.step_count
        self._reset(keep_spawned)
        self._world.step_count = steps

    def _restore(self, snapshot: str) -> None:
        self._world.restore(base64.b64decode(snapshot, validate=True))


_METHODS: dict[str, Callable[..., None]] = {
    "apply_wrench": Operations._apply_wrench,
    "clear_wrenches": Operations._clear_wrenches,
    "apply_impulse": Operations._apply_impulse,
    "move": Operations._move,
    "set_state": Operations._change_body,
    "change_body": Operations._change_body,
    "apply_wrenches": Operations._apply_wrenches,
    "add_body": Operations._add_body,
    "remove_body": Operations._remove_body,
    "reset": Operations._reset,
    "reset_state": Operations._reset_state,
    "restore": Operations._restore,
    "reset_time": Operations._reset_time,
}


_PLAIN = (float, int, str, bool, type(None))


def plain(value: Any) -> Any:
    """Arrays and tuples as lists, numpy numbers as Python's; nothing else changes."""
    if type(value) in _PLAIN:
        return value
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [v if type(v) in _PLAIN else plain(v) for v in value]
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    return value


def to_json(operation: Operation) -> str:
    """Raises ValueError for NaN and infinity."""
    content = {"step": operation.step, "name": operation.name, "arguments": operation.arguments}
    return json.dumps(content, allow_nan=False)


def from_json(text: str) -> Operation:
    """Raises ValueError for text that isn't an operation."""
    try:
        content = json.loads(text)
        return Operation(int(content["step"]), str(content["name"]), dict(content["arguments"]))
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"a logged operation is damaged: {error!r}") from None
