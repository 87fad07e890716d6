"""replay_node refuses what the recording doesn't hold, and changes nothing by a call it refuses."""

import time

import pytest
from geometry_msgs.msg import PoseArray
from harness import wait_for
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"start": 100.0}, "start is 100 s, but the recording goes from 0 to 1 s"),
        ({"topics": "/clock", "exclude_topics": "/clock"}, "no topic is left to publish"),
    ],
    ids=["start", "topics"],
)
def test_nothing_to_play_is_told(replay, recording, values, words):
    node = replay(recording=recording, **values)
    assert node.wait() == 2
    (line,) = [text for text in node.output.splitlines() if text.startswith("replay_node: ")]
    assert words in line


def test_seek_stays_within_the_recording_and_is_told_at_once(client, replay, recording):
    node = replay(recording=recording, paused=True, loop=True)

    def call(name):
        return client.call(Trigger, f"/replay_node/{name}")

    def change(value):
        request = SetParameters.Request(
            parameters=[Parameter("seek_time", value=value).to_parameter_msg()]
        )
        return client.call(SetParameters, "/replay_node/set_parameters", request).results[0]

    refused = change(500.0)
    assert not refused.successful
    assert refused.reason == "parameter seek_time is 500 s, but the recording goes from 0 to 1 s"
    assert change(0.5).successful
    assert call("seek").success
    assert call("is_paused").message == "paused at 0.5 s"  # though nothing was sent since
    assert change(1.0).successful  # the last moment is one of the recording
    assert call("seek").success
    assert call("is_paused").message == "paused at 1 s"
    assert node.process.poll() is None


def test_a_change_that_is_refused_changes_nothing(client, replay, recording):
    replay(recording=recording, rate=0.05, loop=True)
    poses = client.collect(PoseArray, "/sim_node/poses")
    wait_for(lambda: poses, "poses")
    asked = [Parameter("rate", value=50.0), Parameter("seek_time", value=-1.0)]
    answer = client.call(
        SetParametersAtomically,
        "/replay_node/set_parameters_atomically",
        SetParametersAtomically.Request(parameters=[p.to_parameter_msg() for p in asked]),
    ).result
    assert not answer.successful
    assert "seek_time is -1.0" in answer.reason
    request = GetParameters.Request(names=["rate"])
    values = client.call(GetParameters, "/replay_node/get_parameters", request).values
    assert values[0].double_value == 0.05
    before = len(poses)
    time.sleep(1.0)
    # 100 poses a second of the recording: 5 at this rate, 100 at least (a round and more) at the other
    assert len(poses) - before < 20
