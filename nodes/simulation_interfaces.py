"""The services of the package simulation_interfaces, where it is installed.

Offered: state (play, pause, stop, quit), stepping (by a service or the action SimulateSteps), reset,
and entities, which are the bodies: states, bounds, adding and removing them. GetSimulatorFeatures
lists what is offered.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from typing import Any

from geometry_msgs.msg import Vector3
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from rb_physics.queries import bounding_box

from . import entities
from .entities import EntityError
from .entity_bounds import overlapping
from .name_pattern import NamePattern
from .physics_loop import PhysicsLoop
from .simulate_steps import SimulateSteps
from .wrench_inputs import Perform

OFFERED = [
    "SPAWNING",
    "DELETING",
    "SPAWNING_RESOURCE_STRING",
    "ENTITY_STATE_GETTING",
    "ENTITY_STATE_SETTING",
    "ENTITY_INFO_GETTING",
    "ENTITY_CATEGORIES",
    "ENTITY_BOUNDS",
    "ENTITY_BOUNDS_BOX",
    "ENTITY_BOUNDS_CONVEX",
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
OFFERED_WITH_ACTIONS = "STEP_SIMULATION_ACTION"
ACTIONS = ["SimulateSteps"]
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
    "GetEntityBounds",
    "SpawnEntity",
    "DeleteEntity",
]


def load_messages() -> tuple[Any, Any, Any] | None:
    """The modules (msg, srv, action) of simulation_interfaces, or None where it isn't installed.

    The last is None in installations without the action.
    """
    try:
        msg, srv = (import_module(f"simulation_interfaces.{kind}") for kind in ("msg", "srv"))
    except ImportError:
        return None
    try:
        action = import_module("simulation_interfaces.action")
    except ImportError:
        action = None
    return msg, srv, action


def snake_case(name: str) -> str:
    """GetEntityState -> get_entity_state."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


class SimulationInterfaces:
    """Answers the services by orders to the physics thread.

    Parameters
    ----------
    loop: the physics loop. perform: changes the world and logs it (in the physics thread).
    msg, srv, action: the modules of simulation_interfaces.
    """

    def __init__(
        self, loop: PhysicsLoop, perform: Perform, msg: Any, srv: Any, action: Any = None
    ) -> None:
        self._loop = loop
        self._perform = perform
        self._msg = msg
        self._srv = srv
        self._action = action
        self._steps: SimulateSteps | None = None
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
        if self._action is not None:
            self._steps = SimulateSteps(node, self._loop, self._action.SimulateSteps, self._msg)

    def destroy(self, node: Node) -> None:
        """Take the services away."""
        if self._steps is not None:
            self._steps.destroy()
        for service in self._services:
            node.destroy_service(service)

    # -- the simulator ----------------------------------------------------------------------------

    def get_simulator_features(self, _: Any, response: Any) -> Any:
        features = self._msg.SimulatorFeatures
        offered = OFFERED if self._action is None else [*OFFERED, OFFERED_WITH_ACTIONS]
        response.features.features = [getattr(features, name) for name in offered]
        response.features.spawn_formats = list(entities.FORMATS)
        response.features.custom_info = "rb_physics: rigid bodies in contact; see docs/ros.md"
        return response

    def get_simulation_state(self, _: Any, response: Any) -> Any:
        response.state.state = self._state()
        return self._answer(response, True, "")

    def _state(self) -> int:
        states = self._msg.SimulationState
        if not self._loop.paused and not self._loop.held:
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
        if wanted == states.STATE_PLAYING and self._loop.held:
            return self._answer(response, False, "the node is inactive: activate it first")
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
        known = scopes.SCOPE_STATE | scopes.SCOPE_TIME | scopes.SCOPE_SPAWNED
        if scope != scopes.SCOPE_ALL and scope & ~known:
            return self._answer(
                response, False, f"scope is {scope}, but must be a sum of those of ResetSimulation"
            )
        answer = self._loop.commands.ask(
            "restart",
            bool(scope & scopes.SCOPE_STATE),
            bool(scope & scopes.SCOPE_TIME),
            bool(scope & scopes.SCOPE_SPAWNED),
        )
        return self._answer(response, *answer)

    # -- entities ---------------------------------------------------------------------------------

    def get_entities(self, request: Any, response: Any) -> Any:
        def read() -> None:
            response.entities = self._filtered(request.filters)

        return self._act(response, read)

    def get_entity_state(self, request: Any, response: Any) -> Any:
        name = request.entity
        return self._act(
            response, lambda: entities.get_state(self._world, self._known(name), response.state)
        )

    def get_entities_states(self, request: Any, response: Any) -> Any:
        def read() -> None:
            names = self._filtered(request.filters)
            states = [self._msg.EntityState() for _ in names]
            for name, state in zip(names, states, strict=True):
                entities.get_state(self._world, name, state)
            response.entities, response.states = names, states

        return self._act(response, read)

    def set_entity_state(self, request: Any, response: Any) -> Any:
        def write() -> None:
            name = self._known(request.entity)
            entities.set_state(self._world, name, request.state, self._perform)

        return self._act(response, write)

    def spawn_entity(self, request: Any, response: Any) -> Any:
        try:
            body = entities.description(request)  # here: reading files would hold the simulation up
        except EntityError as error:
            return self._refuse(response, error)

        def add() -> None:
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

    def get_entity_bounds(self, request: Any, response: Any) -> Any:
        def read() -> None:
            box = bounding_box(self._world[self._known(request.entity)])
            kinds = self._msg.Bounds
            response.bounds.type = kinds.TYPE_EMPTY if box is None else kinds.TYPE_BOX
            for corner in reversed(box or ()):  # the upper one comes first
                x, y, z = corner.tolist()
                response.bounds.points.append(Vector3(x=x, y=y, z=z))

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
        return self._refuse(response, failed[0]) if failed else response

    def _refuse(self, response: Any, error: EntityError) -> Any:
        code = getattr(response, error.result, getattr(self._msg.Result, error.result, None))
        response.result.result, response.result.error_message = code, str(error)
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

    def _filtered(self, filters: Any) -> list[str]:
        """Names that pass all filters, in the physics thread. Raises EntityError."""
        try:
            pattern = NamePattern(filters.filter)
        except ValueError as error:
            raise EntityError(
                "RESULT_OPERATION_FAILED", f"filter '{filters.filter}' is no pattern: {error}"
            ) from None
        categories = {category.category for category in filters.categories}
        names = [] if filters.tags.tags else self._names()  # no body has tags
        names = [name for name in names if pattern.search(name)]
        if categories:
            names = [name for name in names if self._category(name) in categories]
        if filters.bounds.type == self._msg.Bounds.TYPE_EMPTY:
            return names
        try:
            return overlapping([self._world[name] for name in names], filters.bounds)
        except ValueError as error:
            raise EntityError("RESULT_OPERATION_FAILED", str(error)) from None
