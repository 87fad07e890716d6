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
add_body           description: a body as in a scene file
remove_body        body
reset              back to the state and time at the start of the recording
reset_state        back to that state; time goes on
=================  =================================================================
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np


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

    def _set_state(self, body: str, **arguments: Any) -> None:
        for field in ("position", "orientation", "linear_velocity", "angular_velocity"):
            if arguments.get(field) is not None:
                setattr(self._world[body], field, arguments[field])

    def _add_body(self, description: dict[str, Any]) -> None:
        from ..scene import add_body

        add_body(self._world, description)

    def _remove_body(self, body: str) -> None:
        self._world.remove(self._world[body])

    def _reset(self) -> None:
        self._world.restore(self._initial)

    def _reset_state(self) -> None:
        steps = self._world.step_count
        self._world.restore(self._initial)
        self._world.step_count = steps


_METHODS: dict[str, Callable[..., None]] = {
    "apply_wrench": Operations._apply_wrench,
    "clear_wrenches": Operations._clear_wrenches,
    "apply_impulse": Operations._apply_impulse,
    "move": Operations._move,
    "set_state": Operations._set_state,
    "add_body": Operations._add_body,
    "remove_body": Operations._remove_body,
    "reset": Operations._reset,
    "reset_state": Operations._reset_state,
}


def plain(value: Any) -> Any:
    """Arrays and tuples as lists, numpy numbers as Python's; nothing else changes."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
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
