"""replay_node publishes a recording again: the same bytes' content, timing, start and loop."""

import time

import pytest
from geometry_msgs.msg import PoseArray, WrenchStamped
from harness import wait_for
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Trigger

import rb_physics as rb
from rb_physics.recording import Recorder


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def test_everything_comes_again_in_its_time(client, replay, recording):
    replay(recording=recording, rate=0.5, loop=True)
    poses = client.collect(PoseArray, "/sim_node/poses")
    clock = client.collect(Clock, "/clock")
    names = client.collect(String, "/sim_node/body_names", latched=True)
    wait_for(lambda: len(poses) > 20, "poses")
    begin, first = time.monotonic(), seconds(poses[-1].header.stamp)
    wait_for(lambda: seconds(poses[-1].header.stamp) >= min(first + 0.3, 1.0), "0.3 s of time")
    if first + 0.3 <= 1.0:
        assert time.monotonic() - begin > 0.4  # 0.6 s at half speed, less what was queued
    wait_for(lambda: seconds(poses[-1].header.stamp) < first, "the second round")
    assert names[0].data == '["ground", "crate", "floater"]'
    for (
        message
    ) in poses:  # free fall under 10 m/s²: exact up to the rounding of 1000 sums of size 5000
        fallen = 5.0 * seconds(message.header.stamp) ** 2
        assert message.poses[2].position.z == pytest.approx(5000.0 - fallen, abs=1e-9)
    assert clock


def test_start_skips_but_latched_topics_come(client, replay, recording):
    node = replay(recording=recording, start=0.9, rate=0.01)  # 10 s: time to find each other
    poses = client.collect(PoseArray, "/sim_node/poses")
    names = client.collect(String, "/sim_node/body_names", latched=True)
    wait_for(lambda: names and poses, "names and poses")
    assert seconds(poses[0].header.stamp) >= 0.9
    assert node.wait() == 0


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, "set the parameter recording"),
        ({"recording": "nowhere"}, "nowhere"),
        ({"recording": "RUN", "rate": -1.0}, "rate is -1.0, but must be"),
    ],
    ids=["none", "nowhere", "rate"],
)
def test_errors_are_one_sentence(replay, recording, values, words):
    if values.get("recording") == "RUN":
        values = {**values, "recording": recording}
    node = replay(**values)
    assert node.wait() == 2
    (line,) = [text for text in node.output.splitlines() if text.startswith("replay_node: ")]
    assert words in line
    assert "Traceback" not in node.output


def test_services_and_filters(client, replay, recording):
    node = replay(
        recording=recording,
        rate=0.0,
        paused=True,
        topics="/clock /sim_node/poses",
        exclude_topics="/clock",
    )
    poses = client.collect(PoseArray, "/sim_node/poses")

    def call(name):
        return client.call(Trigger, f"/replay_node/{name}")

    assert call("is_paused").success
    assert client.node.count_publishers("/clock") == 0
    assert call("play_next").success
    wait_for(lambda: len(poses) == 1, "the first message")
    assert seconds(poses[0].header.stamp) == 0.0
    request = SetParameters.Request(
        parameters=[Parameter("seek_time", value=0.5).to_parameter_msg()]
    )
    assert client.call(SetParameters, "/replay_node/set_parameters", request).results[0].successful
    assert call("seek").success
    assert call("play_next").success
    wait_for(lambda: len(poses) == 2, "the message after the seek")
    assert seconds(poses[1].header.stamp) == 0.5
    request = SetParameters.Request(parameters=[Parameter("rate", value=-3.0).to_parameter_msg()])
    (refused,) = client.call(SetParameters, "/replay_node/set_parameters", request).results
    assert not refused.successful
    assert "rate is -3.0" in refused.reason
    assert call("resume").success
    wait_for(lambda: len(poses) == 52, "the rest")
    assert node.wait() == 0


def test_stop_ends_it_and_unknown_topics_are_named(client, replay, recording):
    node = replay(recording=recording, rate=1.0, loop=True)
    assert client.call(Trigger, "/replay_node/stop").success
    assert node.wait() == 0
    node = replay(recording=recording, topics="/nowhere")
    assert node.wait() == 2
    assert "has no topic /nowhere" in node.output


def test_topics_of_a_body_that_was_added_during_the_run_come_too(client, replay, scene, tmp_path):
    loaded = rb.load_scene(scene)
    world = loaded.build()
    ball = {"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "mass": 3, "position": [1, 0, 0.1]}  # fmt: skip
    with Recorder(world, tmp_path / "run", scene=loaded) as recorder:
        for step in range(1000):
            if step == 300:
                recorder.perform("add_body", description=ball)
            world.step()
            recorder.after_step()
    replay(recording=tmp_path / "run", loop=True)
    wrenches = client.collect(WrenchStamped, "/sim_node/bodies/ball/contact_wrench")
    wait_for(lambda: len(wrenches) > 5, "the contact wrench of the ball")
    # 3 kg at rest under 10 m/s²; 1e-9: the solver's residual
    assert wrenches[-1].wrench.force.z == pytest.approx(30.0, abs=1e-9)
