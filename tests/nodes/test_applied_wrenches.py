"""Wrenches from another process: when they act, what is refused, what is counted."""

import math
import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import inputs_status, operations_on, wait_for
from std_msgs.msg import String
from std_srvs.srv import Trigger

FLOATER = "/sim_node/bodies/floater/wrench"


def wrench(frame="world", force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0)):
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.x, message.wrench.force.y, message.wrench.force.z = force
    message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z = torque
    return message


def test_a_wrench_acts_from_its_step_on_and_for_its_timeout(simulator):
    """One message: exactly 100 steps of 6 N on 1 kg, read back from positions before and after."""
    sim = simulator(wrench_timeout=0.1)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(WrenchStamped, FLOATER)
    publisher.publish(wrench(force=(6.0, 0.0, 0.0)))
    (applied,) = wait_for(lambda: operations_on(operations, "apply_wrench"), "the wrench to act")
    assert applied["arguments"]["body"] == "floater"
    assert applied["arguments"]["duration"] == 0.1
    start = applied["step"] * 1e-3
    wait_for(lambda: seconds(poses[-1]) > start + 0.4, "the ball to drift on")
    for message in poses:
        pushed = min(max(seconds(message) - start, 0.0), 0.1)
        coasted = max(seconds(message) - start - 0.1, 0.0)
        x = 3.0 + 0.5 * 6.0 * pushed**2 + 6.0 * 0.1 * coasted
        # Constant force is integrated exactly: what remains is rounding over 500 steps.
        assert abs(message.poses[2].position.x - x) < 1e-12


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


@pytest.mark.parametrize("frame", ["", "crate", "floater/tip", "map"])
def test_unknown_frames_are_refused_with_the_valid_ones_named(simulator, frame):
    sim = simulator()
    publisher = sim.client.publisher(WrenchStamped, FLOATER)
    operations = sim.client.collect(String, "/sim_node/operations")
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    publisher.publish(wrench(frame, force=(6.0, 0.0, 0.0)))
    wait_for(lambda: inputs_status(diagnostics).get("refused_frame") == 1, "the refusal counted")
    assert "must be one of floater, floater/com, world" in sim.node.output
    assert operations == []


def test_nan_and_malformed_messages_are_refused_and_counted(simulator):
    sim = simulator(wrench_timeout=-1.0)
    publisher = sim.client.publisher(WrenchStamped, FLOATER)
    operations = sim.client.collect(String, "/sim_node/operations")
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    for _ in range(3):
        publisher.publish(wrench(force=(math.nan, 0.0, 0.0)))
    publisher.publish(wrench(torque=(0.0, math.inf, 0.0)))
    publisher.publish(b"\x00\x01\x00\x00" + b"\x07" * 30)
    publisher.publish(b"\x00\x01\x00\x00")
    wait_for(lambda: inputs_status(diagnostics).get("refused") == 6, "six refusals")
    status = inputs_status(diagnostics)
    assert status["refused_value"] == 4
    assert status["refused_malformed"] == 2
    assert status["accepted"] == 0
    assert operations == []
    publisher.publish(wrench(force=(1.0, 0.0, 0.0)))  # it still listens
    wait_for(lambda: operations_on(operations, "apply_wrench"), "a good wrench to act")
    assert "must be finite" in sim.node.output
    # Each reason is named; the same one on the same topic within a second is not printed again.
    assert sim.node.output.count("refused") == 4


def test_clear_wrenches_lets_go(simulator):
    sim = simulator(wrench_timeout=-1.0)
    operations = sim.client.collect(String, "/sim_node/operations")
    sim.client.publisher(WrenchStamped, FLOATER).publish(wrench(force=(6.0, 0.0, 0.0)))
    wait_for(lambda: operations_on(operations, "apply_wrench"), "the wrench to act")
    answer = sim.client.call(Trigger, "/sim_node/clear_wrenches")
    assert answer.success
    assert answer.message == "cleared 1 applied wrench"
    wait_for(lambda: operations_on(operations, "clear_wrenches"), "it to be cleared")


def test_a_flood_on_one_topic_is_taken_in_without_loss_of_steps(simulator):
    """20 000 messages as fast as a publisher can: none crashes, every one is accounted for."""
    sim = simulator()
    publisher = sim.client.publisher(WrenchStamped, FLOATER)
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    message = wrench(force=(0.1, 0.0, 0.0))
    for _ in range(20_000):
        publisher.publish(message)
    end = time.monotonic() + 3.0
    wait_for(lambda: time.monotonic() > end and inputs_status(diagnostics), "two diagnostics")
    status = inputs_status(diagnostics)
    assert status["received"] > 0
    assert status["accepted"] + status["dropped"] == status["received"]
    assert sim.node.process.poll() is None
