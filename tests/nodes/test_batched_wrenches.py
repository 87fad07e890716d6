"""~/wrenches: wrenches on many bodies in one message."""

import math

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, Transform, Wrench, WrenchStamped
from harness import inputs_status, operations_on, wait_for
from sensor_msgs.msg import MultiDOFJointState
from std_msgs.msg import String

TOPIC = "/sim_node/wrenches"
SCENE = """
dt: 0.001
gravity: [0, 0, 0]
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: -9}}
  - {name: a, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2, position: [0, 0, 0],
     orientation: [0, 0, 0.7071067811865476, 0.7071067811865476],
     frames: {tip: {position: [0.5, 0, 0]}}}
  - {name: b, shape: {type: sphere, radius: 0.1}, mass: 1, position: [0, 5, 0]}
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


def batch(frame, **forces):
    message = MultiDOFJointState(joint_names=list(forces))
    message.header.frame_id = frame
    for force in forces.values():
        wrench = Wrench()
        wrench.force.x, wrench.force.y, wrench.force.z = force
        message.wrench.append(wrench)
    return message


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def test_all_bodies_are_pushed_from_the_same_step_on(simulator):
    sim = simulator(wrench_timeout=0.1)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(MultiDOFJointState, TOPIC)
    publisher.publish(batch("world", a=(8.0, 0.0, 0.0), b=(0.0, 0.0, 3.0)))
    (applied,) = wait_for(lambda: operations_on(operations, "apply_wrenches"), "the wrenches")
    assert applied["arguments"]["bodies"] == ["a", "b"]
    start = applied["step"] * 1e-3
    wait_for(lambda: poses and seconds(poses[-1]) > start + 0.2, "the bodies to drift on")
    for message in poses:
        pushed = min(max(seconds(message) - start, 0.0), 0.1)
        coasted = max(seconds(message) - start - 0.1, 0.0)
        way = 0.5 * pushed**2 + 0.1 * coasted  # for 1 m/s²
        # Constant force is integrated exactly: what remains is rounding over some hundred steps.
        assert abs(message.poses[1].position.x - 4.0 * way) < 1e-12
        assert abs(message.poses[2].position.z - 3.0 * way) < 1e-12


def test_body_frames_are_those_of_each_body(simulator):
    sim = simulator(wrench_timeout=0.0)
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(MultiDOFJointState, TOPIC)
    publisher.publish(batch("NAME/com", a=(1.0, 0.0, 0.0), b=(2.0, 0.0, 0.0)))
    (applied,) = wait_for(lambda: operations_on(operations, "apply_wrenches"), "the wrenches")
    assert applied["arguments"]["frame"] == "body"
    assert [row[:3] for row in applied["arguments"]["wrenches"]] == [[1, 0, 0], [2, 0, 0]]
    publisher.publish(batch("NAME/tip", a=(0.0, 4.0, 0.0)))
    (single,) = wait_for(lambda: operations_on(operations, "apply_wrench"), "the wrench at the tip")
    # 4 N along y at 0.5 m along x: 2 N m about z
    assert single["arguments"]["torque"] == [0.0, 0.0, 2.0]


def test_it_is_a_source_of_its_own_and_lets_go_of_bodies_it_no_longer_names(simulator):
    sim = simulator(wrench_timeout=-1.0)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    many = sim.client.publisher(MultiDOFJointState, TOPIC)
    single = sim.client.publisher(WrenchStamped, "/sim_node/bodies/b/wrench")
    many.publish(batch("world", a=(1.0, 0.0, 0.0), b=(1.0, 0.0, 0.0)))
    message = WrenchStamped()
    message.header.frame_id = "world"
    message.wrench.force.x = -1.0
    single.publish(message)
    # Both hold for ever and cancel: b moves on with the velocity it had, a is accelerated.
    wait_for(lambda: operations_on(operations, "apply_wrench"), "the single one")
    many.publish(batch("world", b=(1.0, 0.0, 0.0)))
    (cleared,) = wait_for(lambda: operations_on(operations, "clear_wrenches"), "a to be let go")
    assert cleared["arguments"]["body"] == "a"
    assert cleared["arguments"]["source"] is not None
    start = cleared["step"] * 1e-3
    wait_for(lambda: poses and seconds(poses[-1]) > start + 0.2, "both to coast")
    late = [m for m in poses if seconds(m) > start]
    for row in (1, 2):
        x = [m.poses[row].position.x for m in late]
        speeds = [(b - a) / (seconds(n) - seconds(m)) for a, b, m, n in zip(x, x[1:], late, late[1:], strict=False)]  # fmt: skip
        # No force is left on either. 1e-9: differences over 10 ms of positions of up to a metre
        assert max(speeds) - min(speeds) < 1e-9


def with_a_transform():
    message = batch("world", a=(1.0, 0.0, 0.0))
    message.transforms.append(Transform())
    return message


BAD = [
    (with_a_transform(), "transforms has 1 entries, but must stay empty", "value"),
    (batch("world", nobody=(1.0, 0.0, 0.0)), "no dynamic body 'nobody'; there are a, b", "body"),
    (batch("world", ground=(1.0, 0.0, 0.0)), "no dynamic body 'ground'", "body"),
    (batch("world", a=(math.nan, 0.0, 0.0), b=(1.0, 0.0, 0.0)), "must be finite", "value"),
    (batch("NAME/tip", b=(1.0, 0.0, 0.0)), "must be one of b, b/com, world", "frame"),
    (batch("", a=(1.0, 0.0, 0.0)), "empty frame", "frame"),
    (batch("map", a=(1.0, 0.0, 0.0)), "frame 'map' refused", "frame"),
]


@pytest.mark.parametrize(("message", "words", "counter"), BAD, ids=[words for _, words, _ in BAD])
def test_a_message_with_a_mistake_is_refused_as_a_whole(simulator, message, words, counter):
    sim = simulator()
    operations = sim.client.collect(String, "/sim_node/operations")
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    sim.client.publisher(MultiDOFJointState, TOPIC).publish(message)
    wait_for(lambda: words in sim.node.output, "a line about it")
    wait_for(lambda: inputs_status(diagnostics).get(f"refused_{counter}") == 1, "its counter")
    assert operations == []


def test_names_and_wrenches_must_match_and_bytes_be_a_message(simulator):
    sim = simulator()
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    publisher = sim.client.publisher(MultiDOFJointState, TOPIC)
    wrong = batch("world", a=(1.0, 0.0, 0.0))
    wrong.joint_names.append("b")
    publisher.publish(wrong)
    wait_for(lambda: "2 joint_names but 1 wrenches" in sim.node.output, "a line about it")
    twice = batch("world", a=(1.0, 0.0, 0.0), b=(1.0, 0.0, 0.0))
    twice.joint_names[1] = "a"
    publisher.publish(twice)
    publisher.publish(b"\x00\x01\x00\x00" + b"\xff" * 40)
    wait_for(lambda: inputs_status(diagnostics).get("refused") == 3, "three refusals")
    status = inputs_status(diagnostics)
    kinds = [status[f"refused_{kind}"] for kind in ("value", "body", "malformed")]
    assert kinds == [1, 1, 1]
