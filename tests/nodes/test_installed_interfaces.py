"""simulation_interfaces and tf2_msgs as they are where ROS has them installed.

The wheels have neither: `python tests/nodes/interfaces/build.py FOLDER` builds them and prints the
environment in which these tests run.
"""

import math

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseArray, TransformStamped, Vector3, WrenchStamped
from harness import wait_for
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from rb_physics.recording.replay import verify
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


PENDULUM = """<robot name="pendulum">
  <link name="bob">
    <inertial><origin xyz="0 0 0.2"/><mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="rod">
    <collision><geometry><cylinder radius="0.02" length="0.4"/></geometry></collision></link>
  <joint name="weld" type="fixed"><origin xyz="0 0 0.2"/><parent link="bob"/><child link="rod"/></joint>
</robot>"""


def test_urdf_is_spawned_and_its_bounds_are_told(simulator, tmp_path):
    sim = simulator(start_paused=True, record_dir=tmp_path / "runs")
    assert "urdf" in call(sim, "GetSimulatorFeatures").features.spawn_formats
    path = tmp_path / "pendulum.urdf"
    path.write_text(PENDULUM)
    request = srv.SpawnEntity.Request(uri=path.as_uri())
    request.initial_pose.pose.position.z = 5.0
    spawned = sim.client.call(srv.SpawnEntity, "/sim_node/spawn_entity", request)
    assert (spawned.result.result, spawned.entity_name) == (Result.RESULT_OK, "pendulum")
    bounds = call(sim, "GetEntityBounds", entity="pendulum").bounds
    assert bounds.type == msg.Bounds.TYPE_BOX
    upper, lower = [(p.x, p.y, p.z) for p in bounds.points]
    assert upper == pytest.approx((0.1, 0.1, 0.4), abs=1e-15)  # sums of such numbers
    assert lower == pytest.approx((-0.1, -0.1, -0.1), abs=1e-15)
    assert call(sim, "StepSimulation", steps=100).result.result == Result.RESULT_OK
    fallen = call(sim, "GetEntityState", entity="pendulum").state.pose.position.z
    assert fallen == pytest.approx(5.0 - 10.0 * 0.1**2 / 2, abs=1e-12)  # rounding of the sum
    filters = msg.EntityFilters()
    filters.bounds.type = msg.Bounds.TYPE_SPHERE
    filters.bounds.points = [Vector3(z=5.0), Vector3(x=0.5)]
    assert call(sim, "GetEntities", filters=filters).entities == ["pendulum"]
    assert sim.node.stop() == 0, sim.node.output
    (run,) = (tmp_path / "runs").iterdir()
    assert verify(run).difference is None


def test_steps_by_an_action_can_be_followed_and_cancelled(simulator):
    action = pytest.importorskip("simulation_interfaces.action")
    sim = simulator(start_paused=True)
    features = call(sim, "GetSimulatorFeatures").features.features
    assert msg.SimulatorFeatures.STEP_SIMULATION_ACTION in features
    client = ActionClient(sim.client.node, action.SimulateSteps, "/sim_node/simulate_steps")
    wait_for(client.server_is_ready, "the action")
    told = []

    def send(steps):
        goal = action.SimulateSteps.Goal(steps=steps)
        future = client.send_goal_async(goal, lambda m: told.append(m.feedback))
        wait_for(future.done, "the goal to be accepted")
        handle = future.result()
        assert handle.accepted
        return handle, handle.get_result_async()

    def outcome(result):
        wait_for(result.done, "the result")
        return result.result().status, result.result().result.result

    _, result = send(500)
    status, answer = outcome(result)
    assert (status, answer.result) == (GoalStatus.STATUS_SUCCEEDED, Result.RESULT_OK)
    wait_for(lambda: told and told[-1].completed_steps == 500, "the last feedback")
    done = [feedback.completed_steps for feedback in told]
    assert done == sorted(set(done)) and len(done) == 100
    assert all(f.completed_steps + f.remaining_steps == 500 for f in told)
    clock = call(sim, "GetEntityState", entity="crate").state.header.stamp
    assert clock.nanosec == 500_000_000

    handle, result = send(10**9)
    wait_for(lambda: told[-1].remaining_steps > 500, "steps of the second goal")
    _, refused = send(3)
    assert outcome(refused)[1].error_message.endswith("another ~/step is in progress")
    cancelled = handle.cancel_goal_async()
    wait_for(cancelled.done, "the cancelling")
    status, answer = outcome(result)
    assert status == GoalStatus.STATUS_CANCELED
    assert "cancelled after" in answer.error_message

    _, result = send(0)
    assert outcome(result)[0] == GoalStatus.STATUS_ABORTED
    playing = SimulationState(state=SimulationState.STATE_PLAYING)
    call(sim, "SetSimulationState", state=playing)
    _, result = send(5)
    status, answer = outcome(result)
    assert (status, answer.result) == (GoalStatus.STATUS_ABORTED, Result.RESULT_OPERATION_FAILED)
    assert answer.error_message == "stepping works only while paused"
    _, result = send(10**9)
    assert sim.node.stop() == 0, sim.node.output


def test_ctrl_c_ends_an_action_that_steps(simulator):
    action = pytest.importorskip("simulation_interfaces.action")
    sim = simulator(start_paused=True)
    client = ActionClient(sim.client.node, action.SimulateSteps, "/sim_node/simulate_steps")
    wait_for(client.server_is_ready, "the action")
    told = []
    client.send_goal_async(action.SimulateSteps.Goal(steps=10**9), told.append)
    wait_for(lambda: len(told) > 3, "steps to be made")
    assert sim.node.stop() == 0, sim.node.output
    assert "Traceback" not in sim.node.output


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
