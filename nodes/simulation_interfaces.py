"""The services of the package simulation_interfaces, where it is installed.

Offered: state (play, pause, stop, quit), stepping, reset, and entities, which are the bodies: their
states, adding and removing them. GetSimulatorFeatures lists what is offered.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from . import entities
from .entities import EntityError
from .physics_loop import PhysicsLoop
from .wrench_inputs import Perform

OFFERED = [
    "SPAWNING",
    "DELETING",
    "SPAWNING_RESOURCE_STRING",
    "ENTITY_STATE_GETTING",
    "ENTITY_STATE_SETTING",
    "ENTITY_INFO_GETTING",
    "ENTITY_CATEGORIES",
    "SIMULATION_RESET",
    "SIMULATION_RESET_TIME",
    "SIMULATION_RESET_STATE",
    "SIMULATION_RESET_SPAWNED",
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
    "SpawnEntity",
    "DeleteEntity",
]


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
        response.features.spawn_formats = list(entities.FORMATS)
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
            self._stopped = False
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
        if self._state() != self._msg.SimulationState.STATE_PAUSED:
            return self._answer(response, False, "stepping works only while paused")
        if request.steps < 1:
            return self._answer(response, False, "steps is 0, but must be at least 1")
        return self._answer(response, *self._loop.commands.ask("step", int(request.steps)))

    def reset_simulation(self, request: Any, response: Any) -> Any:
        scopes = self._srv.ResetSimulation.Request
        scope = request.scope or scopes.SCOPE_ALL
        answer = self._loop.commands.ask(
            "restart",
            bool(scope & scopes.SCOPE_STATE),
            bool(scope & scopes.SCOPE_TIME),
            bool(scope & scopes.SCOPE_SPAWNED),
        )
        return self._answer(response, *answer)

    # -- entities ---------------------------------------------------------------------------------

    def get_entities(self, request: Any, response: Any) -> Any:
        names = self._filtered(request.filters, response)
        if names is not None:
            response.entities = names
        return response

    def get_entity_state(self, request: Any, response: Any) -> Any:
        name = request.entity
        return self._act(
            response, lambda: entities.get_state(self._world, self._known(name), response.state)
        )

    def get_entities_states(self, request: Any, response: Any) -> Any:
        names = self._filtered(request.filters, response)
        if names is None:
            return response
        states = [self._msg.EntityState() for _ in names]

        def read() -> None:
            for name, state in zip(names, states, strict=True):
                entities.get_state(self._world, self._known(name), state)

        self._act(response, read)
        response.entities, response.states = names, states
        return response

    def set_entity_state(self, request: Any, response: Any) -> Any:
        def write() -> None:
            name = self._known(request.entity)
            entities.set_state(self._world, name, request.state, self._perform)

        return self._act(response, write)

    def spawn_entity(self, request: Any, response: Any) -> Any:
        def add() -> None:
            body = entities.description(request)
            response.entity_name = entities.spawn(self._world, body, request, self._perform)

        return self._act(response, add)

    def delete_entity(self, request: Any, response: Any) -> Any:
        name = request.entity
        return self._act(response, lambda: self._perform("remove_body", body=self._known(name)))

    def get_entity_info(self, request: Any, response: Any) -> Any:
        def read() -> None:
            name = self._known(request.entity)
            response.info.category.category = self._category(name)
            response.info.description = f"{self._world[name].type} body"

        return self._act(response, read)

    # -- shared -----------------------------------------------------------------------------------

    @property
    def _world(self) -> Any:
        return self._loop.world

    def _answer(self, response: Any, success: bool, text: str) -> Any:
        result = self._msg.Result
        response.result.result = result.RESULT_OK if success else result.RESULT_OPERATION_FAILED
        response.result.error_message = "" if success else text
        return response

    def _act(self, response: Any, action: Callable[[], None]) -> Any:
        """Do something in the physics thread, between two steps, and say what became of it."""
        failed: list[EntityError] = []

        def guarded() -> None:
            try:
                action()
            except EntityError as error:
                failed.append(error)
                raise

        self._answer(response, *self._loop.commands.ask("call", guarded))
        if failed:
            name = failed[0].result
            response.result.result = getattr(response, name, getattr(self._msg.Result, name, None))
        return response

    def _known(self, name: str) -> str:
        if name not in self._world:
            known = ", ".join(self._names()) or "none"
            raise EntityError("RESULT_NOT_FOUND", f"there is no body '{name}'; there are {known}")
        return name

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
