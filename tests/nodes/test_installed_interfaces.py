"""simulation_interfaces and tf2_msgs as they are where ROS has them installed.

The wheels have neither: `python tests/nodes/interfaces/build.py FOLDER` builds them and prints the
environment in which these tests run.
"""

import math

import pytest
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import wait_for
from rosgraph_msgs.msg import Clock

srv = pytest.importorskip(
    "simulation_interfaces.srv",
    reason="simulation_interfaces is not installed (tests/nodes/interfaces/build.py)",
)
msg = pytest.importorskip("simulation_interfaces.msg")
Result, SimulationState = msg.Result, msg.SimulationState


def call(sim, name, **fields):
    kind = getattr(srv, name)
    service = "".join("_" + c.lower() if c.isupper() else c for c in name).lstrip("_")
    return sim.client.call(kind, f"/sim_node/{service}", kind.Request(**fields))


def test_features_states_steps_and_resets(simulator):
    sim = simulator(start_paused=True)
    clock = sim.client.collect(Clock, "/clock")
    features = call(sim, "GetSimulatorFeatures").features
    known = msg.SimulatorFeatures
    for feature in (known.SPAWNING, known.DELETING, known.ENTITY_STATE_SETTING,
                    known.STEP_SIMULATION_MULTIPLE, known.SIMULATION_RESET_SPAWNED):  # fmt: skip
        assert feature in features.features
    assert features.spawn_formats
    assert call(sim, "GetSimulationState").state.state == SimulationState.STATE_PAUSED
    assert call(sim, "StepSimulation", steps=100).result.result == Result.RESULT_OK
    wait_for(lambda: clock and clock[-1].clock.nanosec == 100_000_000, "100 steps")

    def change(state):
        wanted = SimulationState(state=state)
        return call(sim, "SetSimulationState", state=wanted).result.result

    assert change(SimulationState.STATE_PLAYING) == Result.RESULT_OK
    refused = call(sim, "StepSimulation", steps=1).result
    assert refused.result == Result.RESULT_OPERATION_FAILED
    assert change(SimulationState.STATE_STOPPED) == Result.RESULT_OK
    assert call(sim, "GetSimulationState").state.state == SimulationState.STATE_STOPPED
    assert change(SimulationState.STATE_PAUSED) == Result.RESULT_OK
    assert call(sim, "GetSimulationState").state.state == SimulationState.STATE_PAUSED
    scope = srv.ResetSimulation.Request.SCOPE_ALL
    assert call(sim, "ResetSimulation", scope=scope).result.result == Result.RESULT_OK
    assert change(SimulationState.STATE_QUITTING) == Result.RESULT_OK
    assert sim.node.wait() == 0


def test_entities_are_spawned_moved_read_and_deleted(simulator):
    sim = simulator(start_paused=True)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    request = srv.SpawnEntity.Request(
        name="ball", resource_string="{shape: {type: sphere, radius: 0.1}, mass: 3}"
    )
    request.initial_pose.pose.position.x = 1.0
    request.initial_pose.pose.position.z = 0.1
    spawned = sim.client.call(srv.SpawnEntity, "/sim_node/spawn_entity", request)
    assert (spawned.result.result, spawned.entity_name) == (Result.RESULT_OK, "ball")
    again = sim.client.call(srv.SpawnEntity, "/sim_node/spawn_entity", request)
    assert again.result.result == srv.SpawnEntity.Response.NAME_NOT_UNIQUE
    assert "'ball' is taken" in again.result.error_message
    assert call(sim, "GetEntities").entities == ["ground", "crate", "floater", "ball"]
    wrenches = sim.client.collect(WrenchStamped, "/sim_node/bodies/ball/contact_wrench")
    assert call(sim, "StepSimulation", steps=200).result.result == Result.RESULT_OK
    # 3 kg under 10 m/s²; 1e-9: the solver's residual
    wait_for(lambda: wrenches and abs(wrenches[-1].wrench.force.z - 30.0) < 1e-9, "its weight")
    state = call(sim, "GetEntityState", entity="ball").state
    state.pose.position.x, state.twist.angular.z = 2.0, 4.0
    done = call(sim, "SetEntityState", entity="ball", state=state).result
    assert done.result == Result.RESULT_OK, done.error_message
    read = call(sim, "GetEntityState", entity="ball").state
    assert read.pose.position.x == 2.0
    assert math.isclose(read.twist.angular.z, 4.0, rel_tol=1e-15)
    everyone = call(sim, "GetEntitiesStates")
    assert everyone.entities[3] == "ball"
    assert everyone.states[3].pose.position.x == 2.0
    info = call(sim, "GetEntityInfo", entity="ground").info
    assert info.category.category == msg.EntityCategory.CATEGORY_STATIC_OBJECT
    assert call(sim, "DeleteEntity", entity="ball").result.result == Result.RESULT_OK
    assert call(sim, "DeleteEntity", entity="ball").result.result == Result.RESULT_NOT_FOUND
    wait_for(lambda: len(poses[-1].poses) == 3, "poses without it")
