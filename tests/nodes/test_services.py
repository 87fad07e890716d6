"""~/pause, ~/step, ~/reset, ~/reset_state, ~/clear_wrenches, ~/save, and what they do to time."""

import itertools

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import wait_for
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def test_paused_at_start_then_steps_are_counted(simulator):
    sim = simulator(start_paused=True, step_count=7)
    clock = sim.client.collect(Clock, "/clock")
    first = sim.client.call(Trigger, "/sim_node/step")
    assert first.success
    assert first.message == "at step 7, time 0.007 s"
    assert sim.client.call(Trigger, "/sim_node/step").message == "at step 14, time 0.014 s"
    wait_for(lambda: clock and clock[-1].clock.nanosec == 10_000_000, "the clock message of 0.01 s")


def test_step_is_refused_while_running_and_pause_stops_time(simulator):
    sim = simulator()
    refused = sim.client.call(Trigger, "/sim_node/step")
    assert not refused.success
    assert "call ~/pause first" in refused.message
    paused = sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True))
    assert paused.success
    before = float(paused.message.split()[-2])
    # One step more than where it was paused: no time passed in between.
    after = sim.client.call(Trigger, "/sim_node/step").message
    assert abs(float(after.split()[-2]) - before - 1e-3) < 1e-9  # printed with nine digits
    clock = sim.client.collect(Clock, "/clock")
    running = sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=False))
    assert running.message.startswith("running at time")
    wait_for(lambda: clock and seconds(clock[-1].clock) > before + 0.05, "time to go on")


def test_pause_and_reset_end_a_long_step(simulator):
    sim = simulator(start_paused=True, step_count=10**9)
    client = sim.client.node.create_client(Trigger, "/sim_node/step")
    wait_for(client.service_is_ready, "the service")
    clock = sim.client.collect(Clock, "/clock")
    for order, service, request in (
        ("pause", SetBool, SetBool.Request(data=True)),
        ("reset", Trigger, Trigger.Request()),
    ):
        seen = len(clock)
        stepping = client.call_async(Trigger.Request())
        wait_for(lambda seen=seen: len(clock) > seen + 3, "steps to be made")
        second = sim.client.call(Trigger, "/sim_node/step")
        assert (second.success, second.message) == (False, "another ~/step is in progress")
        assert sim.client.call(service, f"/sim_node/{order}", request).success
        wait_for(stepping.done, "the answer of ~/step")
        assert not stepping.result().success
        assert stepping.result().message.startswith(f"ended by ~/{order} at step")


def test_reset_takes_time_and_state_back(simulator):
    sim = simulator()
    clock = sim.client.collect(Clock, "/clock")
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: poses and poses[-1].poses[2].position.z < 4999.8, "the ball to fall")
    assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    assert sim.client.call(Trigger, "/sim_node/reset").message == "state reset, time is 0 s"
    wait_for(lambda: seconds(clock[-1].clock) == 0.0, "the clock at 0")
    wait_for(lambda: seconds(poses[-1].header.stamp) == 0.0, "the poses at 0")
    assert poses[-1].poses[2].position.z == 5000.0
    times = [seconds(message.clock) for message in clock]
    assert sum(b < a for a, b in itertools.pairwise(times)) == 1  # back exactly once


def test_reset_state_lets_time_go_on(simulator):
    sim = simulator()
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: poses and poses[-1].poses[2].position.z < 4999.8, "the ball to fall")
    assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    answer = sim.client.call(Trigger, "/sim_node/reset_state")
    time = float(answer.message.split()[-2])
    assert time > 0.1  # falling 0.2 m takes 0.2 s
    wait_for(lambda: poses[-1].poses[2].position.z == 5000.0, "the ball back at its start")
    assert abs(seconds(poses[-1].header.stamp) - time) < 1e-9
    times = [seconds(message.header.stamp) for message in poses]
    assert times == sorted(times)


def test_duration_ends_the_node(simulator):
    sim = simulator(duration=0.5, real_time_factor=0.0)
    assert sim.node.wait() == 0


def test_save_writes_into_the_log_folder_and_says_where(simulator, tmp_path):
    sim = simulator(record_dir=tmp_path / "runs", start_paused=True)
    saved = sim.client.call(Trigger, "/sim_node/save")
    assert saved.success
    (run,) = (tmp_path / "runs").iterdir()
    assert saved.message == str(run / "snapshot_000000000.bin")
    assert (run / "snapshot_000000000.bin").stat().st_size > 0
    again = sim.client.call(Trigger, "/sim_node/save")
    assert not again.success  # never overwritten
    assert "exists" in again.message


def test_save_without_a_log_is_refused(simulator):
    refused = simulator(start_paused=True).client.call(Trigger, "/sim_node/save")
    assert not refused.success
    assert "start the node with record_dir" in refused.message


def physics_status(diagnostics):
    for message in reversed(diagnostics):
        for status in message.status:
            if status.name == "sim_node: physics":
                return status
    return None


def test_what_stands_still_is_shown_as_it_stands(simulator):
    sim = simulator(start_paused=True, step_count=3)
    poses = sim.client.collect(PoseArray, "/sim_node/poses")
    clock = sim.client.collect(Clock, "/clock")
    for _ in range(3):
        assert sim.client.call(Trigger, "/sim_node/step").success
    wait_for(lambda: poses and poses[-1].header.stamp.nanosec == 9_000_000, "poses of 9 ms")
    wait_for(lambda: clock and clock[-1].clock.nanosec == 9_000_000, "the clock at 9 ms")
    late = sim.client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: late, "poses for a newcomer")
    assert late[0].header.stamp.nanosec == 9_000_000


def test_diagnostics_go_on_and_tell_what_the_node_does(simulator):
    sim = simulator()
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    wait_for(lambda: diagnostics and physics_status(diagnostics).message == "running", "running")
    assert sim.client.call(SetBool, "/sim_node/pause", SetBool.Request(data=True)).success
    wait_for(lambda: physics_status(diagnostics).message == "paused", "paused")
    seen = len(diagnostics)
    wait_for(lambda: len(diagnostics) > seen + 2, "more of them while paused")


def test_diagnostics_tell_of_a_divergence(simulator):
    sim = simulator()
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    publisher = sim.client.publisher(WrenchStamped, "/sim_node/bodies/floater/wrench")
    push = WrenchStamped()
    push.header.frame_id, push.wrench.force.x = "world", 1e308
    publisher.publish(push)

    def told():
        status = physics_status(diagnostics)
        return status is not None and status.level == b"\x02" and status

    status = wait_for(told, "an error status")
    assert "paused: " in status.message
    assert "floater" in status.message
    assert sim.client.call(Trigger, "/sim_node/reset").success
    wait_for(lambda: physics_status(diagnostics).message == "running", "running again")
