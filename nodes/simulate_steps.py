"""The action SimulateSteps of simulation_interfaces: many steps, with feedback, to be cancelled."""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from .physics_loop import PhysicsLoop

_SHARES = 100  # of all steps, after each of which feedback is sent ...
_MOST = 1000  # ... and after so many steps at the latest


class SimulateSteps:
    """Makes the steps of a goal a share at a time, so that it can be followed and cancelled."""

    def __init__(self, node: Node, loop: PhysicsLoop, action: Any, msg: Any) -> None:
        self._loop = loop
        self._action = action
        self._msg = msg
        self._server = ActionServer(
            node,
            action,
            "~/simulate_steps",
            execute_callback=self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def destroy(self) -> None:
        """Take the action away."""
        self._server.destroy()

    def _execute(self, goal: Any) -> Any:
        steps, done = int(goal.request.steps), 0
        if not self._loop.paused:
            return self._end(goal.abort, "stepping works only while paused")
        if steps < 1:
            return self._end(goal.abort, "steps is 0, but must be at least 1")
        share = min(max(1, steps // _SHARES), _MOST)
        while done < steps:
            if goal.is_cancel_requested:
                return self._end(goal.canceled, f"cancelled after {done} of {steps} steps")
            before = self._loop.step
            success, text = self._loop.commands.ask("step", min(share, steps - done))
            if not success:
                return self._end(goal.abort, f"after {done} of {steps} steps: {text}")
            done += self._loop.step - before
            goal.publish_feedback(
                self._action.Feedback(completed_steps=done, remaining_steps=steps - done)
            )
        return self._end(goal.succeed, "")

    def _end(self, transition: Any, text: str) -> Any:
        transition()
        kind = self._msg.Result
        code = kind.RESULT_OPERATION_FAILED if text else kind.RESULT_OK
        return self._action.Result(result=kind(result=code, error_message=text))
