"""simulation_interfaces and tf2_msgs as they are where ROS has them installed.

The wheels have neither: `python tests/nodes/interfaces/build.py FOLDER` builds them and prints the
environment in which these tests run.
"""

import math

import pytest
from geometry_msgs.msg import PoseArray, TransformStamped, WrenchStamped
from harness import wait_for
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from rb_physics.recording.topics import default_topics_path

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


def test_frames_are_sent_and_a_link_follows_those_of_a_robot(simulator, tmp_path):
    """A robot's process: a fixed base, a link that moves at 0.5 m/s of simulation time."""
    tf2 = pytest.importorskip("tf2_msgs.msg", reason="tf2_msgs is not installed")
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "bodies:\n"
        "  - {name: crate, shape: {type: sphere, radius: 0.1}, mass: 1}\n"
        "  - {name: link, type: kinematic, shape: {type: sphere, radius: 0.1}, position: [0, 9, 0]}\n"
    )
    table = default_topics_path().read_text()
    topics = tmp_path / "topics.yaml"
    topics.write_text(table.replace("frame: NAME, bodies: []", "frame: arm/NAME, bodies: [link]"))
    sim = simulator(scene=scene, topics=topics)
    client = sim.client
    sent = client.collect(tf2.TFMessage, "/tf")
    fixed = client.collect(tf2.TFMessage, "/tf_static", latched=True)
    poses = client.collect(PoseArray, "/sim_node/poses")
    moving = client.publisher(tf2.TFMessage, "/tf")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    base = client.node.create_publisher(tf2.TFMessage, "/tf_static", latched)

    def transform(parent, child, stamp, **translation):
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id, message.header.stamp = parent, stamp
        for axis, value in translation.items():
            setattr(message.transform.translation, axis, value)
        return tf2.TFMessage(transforms=[message])

    def answer(clock):
        time = clock.clock.sec + clock.clock.nanosec * 1e-9
        moving.publish(transform("arm/base", "arm/link", clock.clock, x=0.5 * time))

    base.publish(transform("world", "arm/base", Time().to_msg(), z=2.0))
    client.node.create_subscription(Clock, "/clock", answer, 10)
    wait_for(lambda: poses and poses[-1].poses[1].position.x > 0.5, "the link to follow")
    last = poses[-1]
    time = last.header.stamp.sec + last.header.stamp.nanosec * 1e-9
    assert last.poses[1].position.z == 2.0
    # One interval of 10 ms behind, and what a message is under way on a loaded machine: 0.2 s
    assert 0.5 * (time - 0.2) < last.poses[1].position.x < 0.5 * time + 0.01
    own = [m for m in sent if m.transforms[0].child_frame_id != "arm/link"]
    assert [t.child_frame_id for t in own[-1].transforms] == ["crate"]  # the link's is the robot's
    children = {t.child_frame_id for message in fixed for t in message.transforms}
    assert {"crate/com", "link/com"} <= children
