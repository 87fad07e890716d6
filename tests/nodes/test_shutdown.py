"""SIGINT and SIGTERM at any moment end the node at once, with exit code 0 and a valid bag."""

import signal
import time

import pytest
from geometry_msgs.msg import PoseArray
from harness import NodeProcess, parameters, wait_for
from rosbags.highlevel import AnyReader
from std_srvs.srv import Trigger


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
