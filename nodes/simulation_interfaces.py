"""The services of the package simulation_interfaces, where it is installed.

Offered: state (play, pause, stop, quit), stepping, reset, and reading and setting the state of
entities, which are the bodies. GetSimulatorFeatures lists what is offered.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from .kinematic_inputs import rotate
from .physics_loop import PhysicsLoop
from .wrench_inputs import Perform

OFFERED = [
    "ENTITY_STATE_GETTING",
    "ENTITY_STATE_SETTING",
    "ENTITY_INFO_GETTING",
    "ENTITY_CATEGORIES",
    "SIMULATION_RESET",
    "SIMULATION_RESET_STATE",
    "SIMULATION_STATE_GETTING",
    "SIMULATION_STATE_SETTING",
    "SIMULATION_STATE_PAUSE",
    "STEP_SIMULATION_SINGLE",
    "STEP_SIMULATION_MULTIPLE",
]
SERVICES = [
    "GetSimulatorFeatures",
    "GetSimulationState",
    "SetSimulationState",
    "StepSimulation",
    "ResetSimulation",
    "GetEntities",
    "GetEntityState",
    "GetEntitiesStates",
    "SetEntityState",
    "GetEntityInfo",
]
UNIT_TOLERANCE = 1e-3  # on the norm of a quaternion, as everywhere


def load_messages() -> tuple[Any, Any] | None:
    """The modules (msg, srv) of simulation_interfaces, or None where it isn't installed."""
    try:
        return (
            importlib.import_module("simulation_interfaces.msg"),
            importlib.import_module("simulation_interfaces.srv"),
        )
    except ImportError:
        return None


def snake_case(name: str) -> str:
    """GetEntityState -> get_entity_state."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


class SimulationInterfaces:
    """Answers the services by orders to the physics thread.

    Parameters
    ----------
    loop: the physics loop. perform: changes the world and logs it (in the physics thread).
    msg, srv: the modules of simulation_interfaces.
    """

    def __init__(self, loop: PhysicsLoop, perform: Perform, msg: Any, srv: Any) -> None:
        self._loop = loop
        self._perform = perform
        self._msg = msg
        self._srv = srv
        self._stopped = False
        self._services: list[Any] = []

    def offer(self, node: Node) -> None:
        """Create the services under the node's name."""
        group = ReentrantCallbackGroup()
        for name in SERVICES:
            kind, own = getattr(self._srv, name), snake_case(name)
            service = node.create_service(
                kind, f"~/{own}", getattr(self, own), callback_group=group
            )
            self._services.append(service)

    def destroy(self, node: Node) -> None:
        """Take the services away."""
        for service in self._services:
            node.destroy_service(service)

    # -- the simulator ----------------------------------------------------------------------------

    def get_simulator_features(self, _: Any, response: Any) -> Any:
        features = self._msg.SimulatorFeatures
        response.features.features = [getattr(features, name) for name in OFFERED]
        response.features.custom_info = "rb_physics: rigid bodies in contact; see docs/ros.md"
        return response

    def get_simulation_state(self, _: Any, response: Any) -> Any:
        response.state.state = self._state()
        return self._answer(response, True, "")

    def _state(self) -> int:
        states = self._msg.SimulationState
        if not self._loop.paused:
            self._stopped = False
            return int(states.STATE_PLAYING)
        if self._stopped and self._loop.step == 0:
            return int(states.STATE_STOPPED)
        return int(states.STATE_PAUSED)

    def set_simulation_state(self, request: Any, response: Any) -> Any:
        states, ask = self._msg.SimulationState, self._loop.commands.ask
        wanted = request.state.state
        if wanted == self._state():
            response.result.result = self._srv.SetSimulationState.Response.ALREADY_IN_TARGET_STATE
            response.result.error_message = "the simulation is in this state already"
            return response
        if wanted == states.STATE_PLAYING:
            return self._answer(response, *ask("pause", False))
        if wanted == states.STATE_PAUSED:
            return self._answer(response, *ask("pause", True))
        if wanted == states.STATE_STOPPED:
            ask("pause", True)
            done, text = ask("reset")
            self._stopped = done
            return self._answer(response, done, text)
        if wanted == states.STATE_QUITTING:
            self._loop.finished.set()
            return self._answer(response, True, "")
        response.result.result = self._srv.SetSimulationState.Response.INCORRECT_TRANSITION
        response.result.error_message = "a simulation can be played, paused, stopped or quit"
        return response

    def step_simulation(self, request: Any, response: Any) -> Any:
        if not self._loop.paused:
            return self._answer(response, False, "stepping works only while paused")
        if request.steps < 1:
            return self._answer(response, False, "steps is 0, but must be at least 1")
        return self._answer(response, *self._loop.commands.ask("step", int(request.steps)))

    def reset_simulation(self, request: Any, response: Any) -> Any:
        scopes, ask = self._srv.ResetSimulation.Request, self._loop.commands.ask
        scope = request.scope or scopes.SCOPE_ALL
        if scope & scopes.SCOPE_STATE:
            order = "reset" if scope & scopes.SCOPE_TIME else "reset_state"
            return self._answer(response, *ask(order))
        if scope & scopes.SCOPE_TIME:
            response.result.result = self._msg.Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = "time is reset together with the state only"
            return response
        return self._answer(response, True, "")  # bodies spawned meanwhile: there are none

    # -- entities ---------------------------------------------------------------------------------

    def get_entities(self, request: Any, response: Any) -> Any:
        names = self._filtered(request.filters, response)
        if names is not None:
            response.entities = names
        return response

    def get_entity_state(self, request: Any, response: Any) -> Any:
        if self._known(request.entity, response):
            self._ask(response, lambda: self._fill(response.state, request.entity))
        return response

    def get_entities_states(self, request: Any, response: Any) -> Any:
        names = self._filtered(request.filters, response)
        if names is None:
            return response
        states = [self._msg.EntityState() for _ in names]

        def read() -> None:
            for name, state in zip(names, states, strict=True):
                self._fill(state, name)

        self._ask(response, read)
        response.entities, response.states = names, states
        return response

    def set_entity_state(self, request: Any, response: Any) -> Any:
        name, state = request.entity, request.state
        if not self._known(name, response):
            return response
        body = self._loop.world[name]
        pose, twist = state.pose, state.twist
        position, velocity, spin = (
            np.array([v.x, v.y, v.z]) for v in (pose.position, twist.linear, twist.angular)
        )
        q = pose.orientation
        orientation = np.array([q.x, q.y, q.z, q.w])
        if state.header.frame_id not in ("", "world"):
            text = f"frame '{state.header.frame_id}' is not world"
            return self._answer(response, False, text)
        if body.type == "static":
            return self._answer(response, False, f"body '{name}' is static and can't be moved")
        numbers = np.concatenate((position, orientation, velocity, spin))
        norm = math.sqrt(float(orientation @ orientation))
        if not np.isfinite(numbers).all() or abs(norm - 1.0) > UNIT_TOLERANCE:
            response.result.result = self._srv.SetEntityState.Response.INVALID_POSE
            response.result.error_message = f"state of '{name}' must be finite and its quaternion of length 1, which is {norm:g}"
            return response

        def write() -> None:
            lever = rotate(orientation / norm, np.array(body.center_of_mass))
            self._perform(
                "set_state",
                body=name,
                position=position,
                orientation=orientation / norm,
                linear_velocity=velocity + np.cross(spin, lever),
                angular_velocity=spin,
            )

        return self._ask(response, write)

    def get_entity_info(self, request: Any, response: Any) -> Any:
        if self._known(request.entity, response):
            response.info.category.category = self._category(request.entity)
            response.info.description = f"{self._loop.world[request.entity].type} body"
            self._answer(response, True, "")
        return response

    # -- shared -----------------------------------------------------------------------------------

    def _answer(self, response: Any, success: bool, text: str) -> Any:
        result = self._msg.Result
        response.result.result = result.RESULT_OK if success else result.RESULT_OPERATION_FAILED
        response.result.error_message = "" if success else text
        return response

    def _ask(self, response: Any, action: Callable[[], None]) -> Any:
        return self._answer(response, *self._loop.commands.ask("call", action))

    def _known(self, name: str, response: Any) -> bool:
        if name in self._names():
            return True
        response.result.result = self._msg.Result.RESULT_NOT_FOUND
        response.result.error_message = (
            f"there is no body '{name}'; there are {', '.join(self._names())}"
        )
        return False

    def _names(self) -> list[str]:
        return [body.name for body in self._loop.world.bodies]

    def _category(self, name: str) -> int:
        categories = self._msg.EntityCategory
        kinds = {
            "dynamic": categories.CATEGORY_DYNAMIC_OBJECT,
            "static": categories.CATEGORY_STATIC_OBJECT,
        }
        return int(kinds.get(self._loop.world[name].type, categories.CATEGORY_OBJECT))

    def _filtered(self, filters: Any, response: Any) -> list[str] | None:
        """Names that pass all filters; None (and the answer says why) when that can't be told."""
        if filters.bounds.type != self._msg.Bounds.TYPE_EMPTY:
            response.result.result = self._msg.Result.RESULT_FEATURE_UNSUPPORTED
            response.result.error_message = "filtering by bounds is not offered"
            return None
        try:
            pattern = re.compile(filters.filter)
        except re.error as error:
            self._answer(response, False, f"filter '{filters.filter}' is no pattern: {error}")
            return None
        categories = {category.category for category in filters.categories}
        names = [] if filters.tags.tags else self._names()  # no body has tags
        names = [name for name in names if pattern.search(name)]
        if categories:
            names = [name for name in names if self._category(name) in categories]
        self._answer(response, True, "")
        return names

    def _fill(self, state: Any, name: str) -> None:
        """The state of a body: world frame, twist of the origin of its frame."""
        body, world = self._loop.world[name], self._loop.world
        state.header.frame_id = "world"
        sec, nanosec = divmod(round(world.time * 1e9), 10**9)
        state.header.stamp.sec, state.header.stamp.nanosec = sec, nanosec
        spin = np.array(body.angular_velocity)
        lever = np.array(body.position) - np.array(body.com_position)
        velocity = np.array(body.linear_velocity) + np.cross(spin, lever)
        _set_xyz(state.pose.position, body.position)
        q = state.pose.orientation
        q.x, q.y, q.z, q.w = (float(value) for value in body.orientation)
        _set_xyz(state.twist.linear, velocity)
        _set_xyz(state.twist.angular, spin)


def _set_xyz(vector: Any, values: Sequence[float]) -> None:
    vector.x, vector.y, vector.z = (float(value) for value in values)
