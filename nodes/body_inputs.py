"""Bodies added, removed and changed by text, from topics or services, as operations on the world."""

from __future__ import annotations

from typing import Any

from rb_physics import checks
from rb_physics.errors import SceneError
from rb_physics.recording import TopicError
from rb_physics.scene import parse_body, parse_change

from .refused import RefusedBodyError
from .urdf_body import UrdfError, body_from_urdf, is_urdf
from .wrench_inputs import Perform


def spawn(world: Any, topic: str, text: str, perform: Perform) -> None:
    """Add the body that `text` describes, as in a scene file or URDF. Raises RefusedBodyError."""
    try:
        if is_urdf(text):
            body = body_from_urdf(text, topic)
            checks.name(body["name"], "body")
        else:
            body = parse_body(text, topic)
        perform("add_body", description=body)
    except (SceneError, UrdfError, TopicError) as error:
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
        raise RefusedBodyError(f"{topic} refused: there is no body '{name}'; there are {known}")
