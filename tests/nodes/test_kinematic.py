"""Kinematic bodies follow commanded poses and twists, and push what they meet."""

import json
import math

import pytest
from geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped
from harness import wait_for
from std_msgs.msg import String

SCENE = """
dt: 0.001
bodies:
  - {name: pusher, type: kinematic, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, position: [0, 0, 5]}
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "kinematic.yaml"
    path.write_text(SCENE)
    return path


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def pose(x, yaw=0.0, at=0.0, frame="world"):
    message = PoseStamped()
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(round(at * 1e9), 10**9)
    message.pose.position.x, message.pose.position.z = x, 5.0
    message.pose.orientation.z, message.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def test_a_pose_is_reached_at_its_stamp_in_uniform_motion(simulator):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(PoseStamped, "/sim_node/bodies/pusher/cmd_pose")
    wait_for(lambda: poses, "a pose")
    goal = seconds(poses[-1]) + 1.0
    publisher.publish(pose(x=0.6, yaw=1.2, at=goal))
    wait_for(lambda: seconds(poses[-1]) > goal + 0.1, "the time after the goal")
    begin = json.loads(operations[0].data)["step"] * 1e-3
    assert begin < goal
    moving = 0
    for message in poses:
        share = min(max((seconds(message) - begin) / (goal - begin), 0.0), 1.0)
        moving += 0.0 < share < 1.0
        body = message.poses[0]
        # 1e-12: the sum of up to 1000 equal steps of less than a mm
        assert body.position.x == pytest.approx(0.6 * share, abs=1e-12)
        assert 2 * math.atan2(body.orientation.z, body.orientation.w) == pytest.approx(
            1.2 * share, abs=1e-12
        )
    assert moving > 10


def test_a_twist_is_kept_for_its_timeout_and_turns_with_the_body(simulator):
    sim = simulator(cmd_vel_timeout=0.2)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    publisher = sim.client.publisher(TwistStamped, "/sim_node/bodies/pusher/cmd_vel")
    twist = TwistStamped()
    twist.header.frame_id = "pusher"
    twist.twist.linear.x = 1.0
    twist.twist.angular.z = 5.0
    publisher.publish(twist)
    wait_for(lambda: poses and poses[-1].poses[0].position.y > 0.05, "motion along a circle")
    last = wait_for(
        lambda: (
            len(poses) > 30 and poses[-1].poses[0] == poses[-20].poses[0] and poses[-1].poses[0]
        ),
        "the end of the motion",
    )
    # 200 steps of 5 mrad; then it stands. 1e-9: rounding of 200 quaternion products
    assert 2 * math.atan2(last.orientation.z, last.orientation.w) == pytest.approx(1.0, abs=1e-9)
    # A circle of radius v/ω = 0.2 m; the polygon of 200 sides stays within 1 % of it
    assert last.position.x == pytest.approx(0.2 * math.sin(1.0), rel=0.01)
    assert last.position.y == pytest.approx(0.2 * (1 - math.cos(1.0)), rel=0.01)


def stamped_by_the_wall_clock():
    message = pose(1.0)
    message.header.stamp.sec = 1_790_000_000
    return message


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (pose(1.0, frame="pusher"), "header.frame_id must be one of world"),
        (pose(math.nan), "must be finite"),
        (PoseStamped(), "empty frame refused"),
        (pose(1e30), "must be 1e+20 at most"),
        (stamped_by_the_wall_clock(), "stamps are simulated time"),
    ],
    ids=["frame", "nan", "empty", "huge", "wall clock"],
)
def test_bad_poses_are_refused(simulator, message, words):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    sim.client.publisher(PoseStamped, "/sim_node/bodies/pusher/cmd_pose").publish(message)
    wait_for(lambda: words in sim.node.output, "the line that says why")
    wait_for(lambda: poses, "a pose")
    assert poses[-1].poses[0].position.x == 0.0
