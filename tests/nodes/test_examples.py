"""The example nodes, each as a process of its own beside the simulator."""

import math
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseArray
from harness import TIMEOUT, NodeProcess, operations_on, parameters, wait_for
from nav_msgs.msg import Odometry
from std_msgs.msg import String

from rb_physics.recording.topics import default_topics_path

EXAMPLES = "rb_physics_nodes.examples."


@pytest.fixture
def start(domain):
    """Starts examples and ends them after the test."""
    started = []

    def run(name, **values):
        started.append(NodeProcess(EXAMPLES + name, parameters(**values), domain))
        return started[-1]

    yield run
    for process in started:
        process.close()


def seconds(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9


def test_pose_holder_holds_against_gravity_and_a_push(simulator, start, tmp_path: Path):
    table = default_topics_path().read_text()
    odometry = table.split("~/bodies/NAME/odom")[1]
    changed = odometry.replace("bodies: []", "bodies: [floater]", 1)
    extra = (
        "\n  - {name: ~/bodies/NAME/wrench/gust, content: wrench, type: "
        "geometry_msgs/msg/WrenchStamped, direction: in, bodies: [floater]}\n"
    )
    topics = tmp_path / "topics.yaml"
    topics.write_text(table.replace(odometry, changed) + extra)
    sim = simulator(topics=topics)
    start(
        "pose_holder",
        body="floater",
        position="[3.0, 0.0, 4999.0]",
        mass=1.0,
        inertia=0.004,
        gravity="[0.0, 0.0, -10.0]",
    )
    odom = sim.client.collect(Odometry, "/sim_node/bodies/floater/odom")

    def still(x, z):
        p, v = odom[-1].pose.pose.position, odom[-1].twist.twist.linear
        return math.dist((p.x, p.y, p.z), (x, 0.0, z)) < 0.02 and math.hypot(v.x, v.y, v.z) < 0.02

    # Gravity is fed forward, so it comes to rest at the goal itself.
    wait_for(lambda: odom and still(3.0, 4999.0), "the ball at rest at its goal")
    push = start(
        "pusher",
        topic="/sim_node/bodies/floater/wrench/gust",
        force="[5.0, 0.0, 0.0]",
        duration=1e6,
    )
    # In balance with the push: 5 N / (m ω²) = 5 / (2π·2)² = 31.7 mm away
    offset = 5.0 / (4 * math.pi) ** 2
    wait_for(lambda: still(3.0 + offset, 4999.0), "the ball held against the push")
    wait_for(lambda: abs(odom[-1].pose.pose.position.x - 3.0 - offset) < 0.003, "balance")
    push.stop()
    wait_for(lambda: still(3.0, 4999.0) and odom[-1].pose.pose.position.x < 3.01, "the ball back")


def test_force_sensor_says_that_the_crate_weighs_m_g(simulator, start):
    simulator()
    sensor = start("force_sensor", expected=20.0, tolerance=1e-6)
    wait_for(lambda: "as expected" in sensor.output, "a verdict")
    assert "mean contact force 20.0000 N" in sensor.output
    assert "NOT" not in sensor.output


def test_the_scene_crate_fits_what_the_examples_look_for(simulator, start):
    sim = simulator(scene="crate")
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    sensor = start("force_sensor")  # the crate at rest: 9.81 N
    wait_for(lambda: "as expected" in sensor.output, "a verdict")
    # The thruster's 5 N overcome a friction of 0.3 m g: 2.06 m/s² while it is on.
    start("thruster")
    wait_for(lambda: poses[-1].poses[1].position.x > 0.2, "the crate to slide")
    assert abs(poses[-1].poses[1].position.y) < 1e-6  # no force across: rounding only


def test_wind_reaches_every_dynamic_body(simulator, start):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    start("wind", force="[1.0, 0.0, 0.0]", gust=0.0)
    wait_for(lambda: poses and poses[-1].poses[2].position.x > 3.05, "the ball to drift")
    assert abs(poses[-1].poses[1].position.x) < 1e-3  # friction holds the crate (10 N)


def test_thruster_pushes_along_its_frame(simulator, start):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    start("thruster", frame="crate/tip", thrust="[0.0, 0.0, 60.0]", on_for=100.0)
    wait_for(lambda: poses and poses[-1].poses[1].position.z > 0.5, "the crate to lift off")


def test_keyboard_needs_a_terminal(domain):
    node = NodeProcess(EXAMPLES + "keyboard_wrench", [], domain)
    try:
        assert node.process.wait(30) == 1
        assert "start it in one" in node.output
    finally:
        node.close()


def test_keys_of_a_terminal_push(simulator, domain):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", EXAMPLES + "keyboard_wrench"]
    arguments = parameters(topic="/sim_node/bodies/floater/wrench", force=20.0)
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    process = subprocess.Popen(
        [*command, *arguments], stdin=theirs, stdout=subprocess.DEVNULL, env=environment
    )
    try:
        topic = "/sim_node/bodies/floater/wrench"
        wait_for(lambda: sim.client.node.count_publishers(topic) > 0, "the example")

        def pushed():
            os.write(ours, b"x")  # no such key
            os.write(ours, b"w")
            time.sleep(0.05)
            return operations_on(operations, "apply_wrench")

        applied = wait_for(pushed, "a key to act")
        assert applied[0]["arguments"]["force"] == [20.0, 0.0, 0.0]
        wait_for(lambda: poses and poses[-1].poses[2].position.x > 3.01, "the ball to move")
        process.send_signal(signal.SIGINT)
        assert process.wait(TIMEOUT) == 0
    finally:
        process.kill()
        process.wait()
        os.close(ours)
        os.close(theirs)
