"""Bodies added, removed and changed through topics: YAML text into operations on the world."""

from __future__ import annotations

from typing import Any

from rb_physics.errors import SceneError
from rb_physics.scene import parse_body, parse_change

from .refused import RefusedBodyError
from .wrench_inputs import Perform


def spawn(world: Any, topic: str, text: str, perform: Perform) -> None:
    """Add the body that `text` describes as in a scene file. Raises RefusedBodyError."""
    try:
        perform("add_body", description=parse_body(text, topic))
    except SceneError as error:
        raise RefusedBodyError(f"no body added: {error}") from None


def remove(world: Any, topic: str, text: str, perform: Perform) -> None:
    """Remove the body whose name is `text`. Raises RefusedBodyError."""
    name = text.strip()
    _check_known(world, topic, name)
    perform("remove_body", body=name)


def change(world: Any, topic: str, text: str, perform: Perform) -> None:
    """Set state or surface of a body: `name` and the new values. Raises RefusedBodyError."""
    try:
        given = parse_change(text, topic)
        name = given.pop("name")
        _check_known(world, topic, name)
        if not given:
            raise SceneError(f"{topic}: nothing to change is named beside '{name}'")
        perform("change_body", body=name, **given)
    except SceneError as error:
        raise RefusedBodyError(f"no body changed: {error}") from None


def _check_known(world: Any, topic: str, name: str) -> None:
    if name not in world:
        known = ", ".join(body.name for body in world.bodies) or "none"
        raise RefusedBodyError(
            f"message on {topic} refused: there is no body '{name}'; there are {known}"
        )
