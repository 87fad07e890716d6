"""The services ~/pause ~/step ~/reset ~/reset_state ~/clear_wrenches ~/save ~/spawn ~/remove ~/change."""

from __future__ import annotations

from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from . import body_inputs
from .physics_loop import PhysicsLoop
from .wrench_inputs import Perform

TRIGGERS = {
    "reset": "take time and state back to the start",
    "reset_state": "take the state back to the start, time goes on",
    "clear_wrenches": "let go of every applied wrench",
    "save": "write the state to a file",
}
BODIES = {
    "spawn": body_inputs.spawn,
    "remove": body_inputs.remove,
    "change": body_inputs.change,
}  # what the parameter `body` says, with an answer that the topics of these names don't have


class Services:
    """Hands service calls over to the physics thread and returns its answers.

    Parameters
    ----------
    loop: the physics loop. perform: changes the world and logs it (in the physics thread).
    """

    def __init__(self, node: Node, loop: PhysicsLoop, perform: Perform) -> None:
        self._node = node
        self._loop = loop
        self._commands = loop.commands
        self._perform = perform
        # Reentrant, so that a long ~/step does not keep ~/pause waiting.
        group = ReentrantCallbackGroup()
        calls = {"step": (Trigger, self._step), "pause": (SetBool, self._pause)}
        calls |= {name: (Trigger, self._trigger(name)) for name in TRIGGERS}
        calls |= {name: (Trigger, self._body(name)) for name in BODIES}
        self._services = [
            node.create_service(kind, f"~/{name}", call, callback_group=group)
            for name, (kind, call) in calls.items()
        ]

    def destroy(self, node: Node) -> None:
        """Take the services away."""
        for service in self._services:
            node.destroy_service(service)

    def _pause(self, request: Any, response: Any) -> Any:
        response.success, response.message = self._commands.ask("pause", request.data)
        return response

    def _step(self, _: Any, response: Any) -> Any:
        count = self._node.get_parameter("step_count").value
        response.success, response.message = self._commands.ask("step", count)
        return response

    def _trigger(self, name: str) -> Any:
        def call(_: Any, response: Any) -> Any:
            response.success, response.message = self._commands.ask(name)
            return response

        return call

    def _body(self, name: str) -> Any:
        def call(_: Any, response: Any) -> Any:
            text = self._node.get_parameter("body").value

            def act() -> str:
                BODIES[name](self._loop.world, f"~/{name}", text, self._perform)
                return f"done before step {self._loop.step + 1}"

            response.success, response.message = self._commands.ask("call", act)
            return response

        return call
