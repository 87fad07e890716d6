"""SIGINT and SIGTERM at any moment end the node at once, with exit code 0 and a valid bag."""

import random
import signal
import time

import pytest
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import NodeProcess, parameters, wait_for
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

from rb_physics.recording.replay import verify


def readable_bag(parent):
    (run,) = parent.iterdir()
    with AnyReader([run]) as reader:
        stamps = [stamp for _, stamp, _ in reader.messages()]
    assert stamps == sorted(stamps)
    return stamps


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_while_running_leaves_a_valid_bag(simulator, tmp_path, number):
    sim = simulator(record_dir=tmp_path / "runs")
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: len(poses) > 20, "poses")
    seen = poses[-1].header.stamp
    begin = time.monotonic()
    assert sim.node.stop(number) == 0
    assert time.monotonic() - begin < 10.0  # at once; the limit allows for a loaded machine
    assert readable_bag(tmp_path / "runs")[-1] >= seen.sec * 10**9 + seen.nanosec


@pytest.mark.parametrize("delay", [0.05, 0.3, 0.6, 0.9, 1.2, 1.5])
def test_a_signal_at_any_moment_of_the_start(domain, scene, tmp_path, delay):
    """Before the handlers are set Python's own ends the process; afterwards the exit is clean."""
    node = NodeProcess(
        "rb_physics_nodes.sim_node",
        parameters(scene=scene, record_dir=tmp_path / "runs"),
        domain,
    )
    try:
        time.sleep(delay)  # the moment itself is what is varied: nothing to wait for
        node.process.send_signal(signal.SIGTERM)
        assert node.wait() in (0, -signal.SIGTERM)
        assert "Traceback" not in node.output
    finally:
        node.close()
    if (tmp_path / "runs").exists() and list((tmp_path / "runs").iterdir()):
        readable_bag(tmp_path / "runs")


def test_a_signal_while_a_service_call_steps(simulator):
    sim = simulator(start_paused=True, step_count=10**9)
    client = sim.client.node.create_client(Trigger, "/sim_node/step")
    wait_for(client.service_is_ready, "the service")
    client.call_async(Trigger.Request())
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: len(poses) > 3, "steps to be made")
    assert sim.node.stop() == 0, sim.node.output


@pytest.mark.parametrize(
    "seed", [1, 2, *(pytest.param(n, marks=pytest.mark.soak) for n in range(3, 23))]
)
def test_ctrl_c_at_any_moment_of_a_busy_run(simulator, tmp_path, seed):
    """Messages and calls come in all the while; once more when the first wasn't quick enough."""
    dice = random.Random(seed)
    sim = simulator(record_dir=tmp_path / "runs", rerun=dice.choice(["'off'", "file"]))
    push = sim.client.publisher(WrenchStamped, "/sim_node/bodies/floater/wrench")
    spawn = sim.client.publisher(String, "/sim_node/spawn")
    services = [
        sim.client.node.create_client(Trigger, f"/sim_node/{name}")
        for name in ("reset", "reset_state", "clear_wrenches", "save", "step")
    ]
    message = WrenchStamped()
    message.header.frame_id = "world"
    end = time.monotonic() + dice.uniform(0.0, 1.5)
    number = 0
    while time.monotonic() < end:
        message.wrench.force.x = dice.uniform(-1.0, 1.0)
        push.publish(message)
        number += 1
        if number % 20 == 0:
            dice.choice(services).call_async(Trigger.Request())
            body = f"{{name: b{number}, shape: {{type: sphere, radius: 0.1}}, mass: 1, position: [{number}, 0, 3]}}"
            spawn.publish(String(data=body))
        time.sleep(0.002)  # 500 messages a second
    sim.node.process.send_signal(signal.SIGINT)
    if dice.random() < 0.5:
        time.sleep(dice.uniform(0.0, 0.3))  # the moment of the second one is what is varied
        if sim.node.process.poll() is None:
            sim.node.process.send_signal(signal.SIGINT)
    assert sim.node.wait() == 0, sim.node.output
    assert "Traceback" not in sim.node.output
    (run,) = (tmp_path / "runs").iterdir()
    readable_bag(tmp_path / "runs")
    verification = verify(run)
    assert verification.difference is None, verification.text


def test_a_step_without_end_does_not_keep_the_node_from_ending(simulator, tmp_path):
    """A torque that is finite and far too large, on a body on a mesh, takes minutes to step."""
    sim = simulator(scene="shapes", record_dir=tmp_path / "runs")
    clock = sim.client.collect(Clock, "/clock")
    publisher = sim.client.publisher(WrenchStamped, "/sim_node/bodies/box_on_mesh/wrench")
    wait_for(lambda: clock, "time to run")
    push = WrenchStamped()
    push.header.frame_id, push.wrench.torque.x = "world", 1e13
    publisher.publish(push)
    time.sleep(1.0)
    code = sim.node.stop()
    assert code in (0, 1)  # 0 where the core gives such a step up by itself
    assert code == 0 or "a step has taken more than 5 s" in sim.node.output
    (run,) = (tmp_path / "runs").iterdir()
    with AnyReader([run]) as reader:
        assert reader.message_count > 0
