"""A recorded node run, with everything that was done to it, repeats to the bit."""

import json

from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import NodeProcess, parameters, wait_for
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from rb_physics.recording.replay import Run, verify


def test_a_run_with_wrenches_pauses_and_resets_repeats_from_its_log(simulator, tmp_path):
    sim = simulator(record_dir=tmp_path / "runs", step_count=30)
    client = sim.client
    poses = client.collect(PoseArray, "/sim_node/poses")
    operations = client.collect(String, "/sim_node/operations")
    crate = client.publisher(WrenchStamped, "/sim_node/bodies/crate/wrench")
    floater = client.publisher(WrenchStamped, "/sim_node/bodies/floater/wrench")

    def push(publisher, frame, x):
        message = WrenchStamped()
        message.header.frame_id = frame
        message.wrench.force.x, message.wrench.torque.y = x, 0.1 * x
        publisher.publish(message)

    def wait_steps(count):
        seen = len(poses)
        wait_for(lambda: len(poses) >= seen + count, "more poses")

    for force in (3.0, 12.0, 25.0):
        push(crate, "crate/tip", force)
        push(floater, "world", -force)
        wait_steps(7)
    assert client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    assert client.call(Trigger, "/sim_node/step").success
    assert client.call(Trigger, "/sim_node/reset_state").success
    push(crate, "world", 15.0)
    assert client.call(SetBool, "/sim_node/pause", SetBool.Request(data=False)).success
    wait_steps(10)
    assert client.call(Trigger, "/sim_node/clear_wrenches").success
    assert client.call(Trigger, "/sim_node/reset").success
    push(floater, "floater", 5.0)
    wait_steps(20)
    assert sim.node.stop() == 0
    names = {json.loads(message.data)["name"] for message in operations}
    assert {"apply_wrench", "reset", "reset_state"} <= names
    (run,) = (tmp_path / "runs").iterdir()
    result = verify(run)
    assert result.difference is None, result.text
    assert result.steps > 300


def test_wrenches_of_two_processes_pauses_resets_and_spawned_bodies_repeat_with_any_number_of_threads(
    simulator, domain, tmp_path
):
    sim = simulator(record_dir=tmp_path / "runs", snapshot_interval=0.3)
    spawn = sim.client.publisher(String, "/sim_node/spawn")
    remove = sim.client.publisher(String, "/sim_node/remove")
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    operations = sim.client.collect(String, "/sim_node/operations")
    pushers = [
        NodeProcess("rb_physics_nodes.examples." + name, parameters(**values), domain)
        for name, values in (
            ("wind", {"force": "[1.0, 0.5, 0.0]", "gust": 0.5}),
            ("thruster", {"frame": "crate/tip", "thrust": "[0.0, 0.0, 15.0]", "on_for": 100.0}),
        )
    ]
    try:

        def pushed():
            done = [json.loads(message.data) for message in operations]
            return {o["arguments"].get("body") for o in done if o["name"] == "apply_wrench"}

        wait_for(lambda: {"crate", "floater"} <= pushed(), "wrenches of both processes")
        guest = (
            "{name: guest, shape: {type: sphere, radius: 0.1}, mass: 1, position: [0.05, 0, 0.5]}"
        )
        spawn.publish(String(data=guest))
        wait_for(lambda: "guest" in pushed(), "the wind to reach the spawned body")
        for data in (True, False):
            assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=data)).success
        assert sim.client.call(Trigger, "/sim_node/reset").success
        seen = len(poses)
        wait_for(lambda: len(poses) > seen + 50, "half a second more")
        spawn.publish(String(data=guest.replace("guest", "second")))
        wait_for(lambda: len(poses[-1].poses) == 4, "another spawned body")
        remove.publish(String(data="second"))
        wait_for(lambda: len(poses[-1].poses) == 3, "it to go")
        assert sim.client.call(Trigger, "/sim_node/reset_state").success
    finally:
        for process in pushers:
            process.close()
    assert sim.node.stop() == 0
    (run,) = (tmp_path / "runs").iterdir()
    for threads in (1, 2, 3):
        result = verify(run, threads=threads)
        assert result.difference is None, result.text
    assert result.steps > 500
    for step in Run(run).snapshots:
        result = verify(run, start=step * 0.001)
        assert result.difference is None, (step, result.text)
