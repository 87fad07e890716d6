"""Floods, services from several sides, bodies that come and go, resets during wrenches: the node
goes on, counts, and its log repeats to the bit."""

import json
import random
import threading

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, PoseStamped, TwistStamped, WrenchStamped
from harness import inputs_status, operations_on, wait_for
from rclpy.clock import JumpThreshold
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import MultiDOFJointState
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from rb_physics.recording.replay import verify

WRENCH = "/sim_node/bodies/floater/wrench"


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def push(force, frame="world"):
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.force.x = force
    return message


def test_a_reset_lets_go_of_a_wrench_that_is_held(simulator):
    sim = simulator(wrench_timeout=-1.0)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(WrenchStamped, WRENCH)
    for service in ("reset", "reset_state"):
        publisher.publish(push(50.0))
        wait_for(lambda: poses and poses[-1].poses[2].position.x > 3.01, "the ball to be pushed")
        assert sim.client.call(Trigger, f"/sim_node/{service}").success
        wait_for(lambda: poses[-1].poses[2].position.x == 3.0, "the ball back")
        seen = len(poses)
        wait_for(lambda seen=seen: len(poses) > seen + 10, "further poses")
        assert poses[-1].poses[2].position.x == 3.0  # nothing pushes any more
    # The wrench is taken from the world before the state goes back, so that the log says it.
    names = [json.loads(message.data)["name"] for message in operations]
    assert names == ["apply_wrench", "clear_wrenches", "reset"] + [
        "apply_wrench", "clear_wrenches", "reset_state"]  # fmt: skip


def test_a_reset_after_a_divergence_goes_on(simulator):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    publisher = sim.client.publisher(WrenchStamped, WRENCH)
    publisher.publish(push(1e308))
    wait_for(lambda: "~/reset starts anew" in sim.node.output, "the node to pause")
    assert sim.client.call(Trigger, "/sim_node/reset").success
    seen = len(poses)
    wait_for(lambda: len(poses) > seen + 20, "poses after the reset")


def test_clocks_of_other_nodes_follow_also_backwards(simulator):
    sim = simulator()
    node = sim.client.node
    clock = sim.client.collect(Clock, "/clock")
    node.set_parameters([Parameter("use_sim_time", Parameter.Type.BOOL, True)])
    jumps = []
    threshold = JumpThreshold(
        min_forward=None, min_backward=Duration(nanoseconds=-1), on_clock_change=False
    )
    handle = node.get_clock().create_jump_callback(threshold, post_callback=jumps.append)
    wait_for(lambda: node.get_clock().now().nanoseconds > 300_000_000, "0.3 s of simulation time")
    ticks = []
    node.create_timer(0.05, lambda: ticks.append(node.get_clock().now().nanoseconds))
    wait_for(lambda: len(ticks) > 3, "a timer in simulation time")
    assert sim.client.call(Trigger, "/sim_node/reset").success
    wait_for(lambda: jumps, "the jump back to be noticed")
    assert jumps[0].delta.nanoseconds < 0
    wait_for(lambda: node.get_clock().now().nanoseconds > 100_000_000, "time to go on")
    assert abs(node.get_clock().now().nanoseconds * 1e-9 - seconds(clock[-1].clock)) < 0.5
    seen = len(ticks)
    wait_for(lambda: len(ticks) > seen + 3, "the timer to go on")
    handle.unregister()


def test_stamps_from_any_time_do_not_matter_outside_lockstep(simulator):
    sim = simulator()
    operations = sim.client.collect(String, "/sim_node/operations")
    publisher = sim.client.publisher(WrenchStamped, WRENCH)
    for k, sec in enumerate((0, 2**31 - 1, -5, 12, 3)):
        message = push(1.0 + k)
        message.header.stamp.sec = sec
        publisher.publish(message)
        wait_for(lambda k=k: len(operations_on(operations, "apply_wrench")) == k + 1, "it to act")


def test_everything_at_once(simulator, tmp_path):
    sim = simulator(record_dir=tmp_path / "runs", step_count=20)
    client = sim.client
    diagnostics = client.collect(DiagnosticArray, "/sim_node/diagnostics")
    single = client.publisher(WrenchStamped, WRENCH)
    batch = client.publisher(MultiDOFJointState, "/sim_node/wrenches")
    spawn = client.publisher(String, "/sim_node/spawn")
    remove = client.publisher(String, "/sim_node/remove")
    change = client.publisher(String, "/sim_node/change")
    stop, failures = threading.Event(), []

    def flood():
        dice = random.Random(1)
        while not stop.is_set():
            single.publish(
                push(dice.uniform(-1, 1), dice.choice(["world", "floater", "nowhere", ""]))
            )
            message = MultiDOFJointState(joint_names=dice.sample(["crate", "floater", "x"], 2))
            message.header.frame_id = dice.choice(["world", "NAME/com", "NAME"])
            message.wrench = [push(dice.uniform(-3, 3)).wrench for _ in range(2)]
            batch.publish(message)
            single.publish(bytes(dice.randbytes(dice.randrange(80))))
            stop.wait(0.002)

    def bodies():
        dice = random.Random(2)
        while not stop.is_set():
            name = f"b{dice.randrange(4)}"
            height = dice.uniform(0.2, 2.0)
            spawn.publish(String(data=f"{{name: {name}, shape: {{type: sphere, radius: 0.1}}, mass: 1, position: [{dice.uniform(-2, 2)}, 1, {height}]}}"))  # fmt: skip
            change.publish(String(data=f"{{name: b{dice.randrange(4)}, friction: 0.3}}"))
            stop.wait(0.05)
            remove.publish(String(data=f"b{dice.randrange(4)}"))
            stop.wait(0.05)

    def services():
        dice = random.Random(3)
        while not stop.is_set():
            name = dice.choice(["pause", "step", "reset", "reset_state", "clear_wrenches", "save"])
            try:
                if name == "pause":
                    request = SetBool.Request(data=dice.random() < 0.3)
                    client.call(SetBool, "/sim_node/pause", request)
                else:
                    client.call(Trigger, f"/sim_node/{name}")
            except BaseException as error:  # told by the main thread
                failures.append((name, error))
                return

    threads = [threading.Thread(target=each) for each in (flood, bodies, services)]
    for thread in threads:
        thread.start()
    try:
        stop.wait(8.0)  # the time during which it all happens
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    assert not failures, failures
    client.call(SetBool, "/sim_node/pause", SetBool.Request(data=False))
    seen = len(diagnostics)
    wait_for(lambda: len(diagnostics) > seen + 1, "diagnostics behind it all")
    status = inputs_status(diagnostics)
    ends = (
        "accepted",
        "refused",
        "ignored",
        "dropped",
        "discarded_by_reset",
        "discarded_by_removal",
    )
    assert status["received"] == sum(status[end] for end in ends)
    for counter in ("refused_frame", "refused_body", "refused_malformed"):
        assert status[counter] > 0
    assert sim.node.stop() == 0, sim.node.output
    assert "Traceback" not in sim.node.output
    (run,) = (tmp_path / "runs").iterdir()
    verification = verify(run)
    assert verification.difference is None, verification.text
    assert verification.steps > 100


def test_malformed_motions_are_refused(simulator, tmp_path):
    scene = tmp_path / "kinematic.yaml"
    scene.write_text("bodies: [{name: arm, type: kinematic, shape: {type: sphere, radius: 0.1}}]\n")
    sim = simulator(scene=scene)
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    for kind, name in ((PoseStamped, "cmd_pose"), (TwistStamped, "cmd_vel")):
        publisher = sim.client.publisher(kind, f"/sim_node/bodies/arm/{name}")
        for data in (b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + b"\xff" * 60, b"\x07" * 90):
            publisher.publish(data)
    wait_for(lambda: inputs_status(diagnostics).get("refused_malformed") == 6, "six refusals")
