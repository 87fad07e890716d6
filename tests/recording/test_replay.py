"""verify: identical, or the step, body and quantity that differ."""

from __future__ import annotations

import json

import pytest
import yaml

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.branch import branch
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.mcap_log import Attachment, McapLog
from rb_physics.recording.message_queue import Entry
from rb_physics.recording.replay import verify
from rb_physics.recording.topics import Qos
from rb_physics.resources import packaged_scenes

SCENE = """
dt: 0.002
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: low, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0, 0, 0.1]}
  - {name: high, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 1.0, position: [0, 0, 0.3]}
  - {name: ball, shape: {type: sphere, radius: 0.05}, mass: 0.5, position: [1, 0, 0.3], restitution: 0.5}
  - {name: arm, type: kinematic, shape: {type: sphere, radius: 0.05}, position: [0, 2, 1]}
"""
CRATE = {"name": "crate", "shape": {"type": "box", "half_extents": [0.1, 0.1, 0.1]}, "mass": 1.0,
         "position": [0.5, 0.5, 0.4]}  # fmt: skip


def run_steps(world, recorder, count: int) -> None:
    for _ in range(count):
        world.step()
        recorder.after_step()


def record_eventful(directory) -> None:
    """A run with everything that changes a world in it: 230 steps."""
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, directory, scene=scene, snapshot_interval=0.1) as recorder:
        recorder.perform("apply_wrench", body="high", force=(0.3, 0, 0), duration=0.05)
        recorder.perform("move", body="arm", linear_velocity=(0, 0.1, 0))
        run_steps(world, recorder, 60)
        recorder.perform(
            "apply_wrench", body="low", force=(0, 2, 0), point=(0.1, 0, 0), frame="body"
        )
        run_steps(world, recorder, 20)
        recorder.perform("add_body", description=CRATE)
        run_steps(world, recorder, 40)
        recorder.perform("apply_impulse", body="crate", impulse=(0.1, 0, 0))
        recorder.perform("clear_wrenches", body="low")
        run_steps(world, recorder, 50)
        recorder.perform("remove_body", body="crate")
        run_steps(world, recorder, 20)
        recorder.perform("reset")
        run_steps(world, recorder, 20)
        recorder.perform("reset_state")
        recorder.perform("set_state", body="ball", position=(1, 1, 1), linear_velocity=(0, 0, 1))
        run_steps(world, recorder, 20)


def rewritten(source, target, change) -> None:
    """A copy of a bag in which `change(message)` may replace the bytes of each message."""
    log = Recording(source)
    attachments = [Attachment(n, "", d) for n, d in log.attachments().items()]
    copy = McapLog(target, custom_data=log.custom_data, attachments=attachments)
    ids: dict[str, int] = {}
    for m in log.messages():
        if m.topic not in ids:
            ids[m.topic] = copy.add_topic(m.topic, m.type, Qos())
        copy.write([Entry(ids[m.topic], m.log_time, m.step, change(m))])
    copy.close()


def test_eventful_run_is_identical(tmp_path):
    record_eventful(tmp_path / "run")
    seen = []
    result = verify(tmp_path / "run", progress=lambda *now: seen.append(now))
    assert result.difference is None, result.text
    assert result.steps == 230
    assert seen[-1] == (230, 230, 0.002)
    assert result.text == "identical, 230 steps, 0.46 s"


def with_hashes_until(source, target, last: float) -> None:
    """A copy of a bag of 230 steps without the state hashes behind `last` s."""
    log = Recording(source)
    attachments = [Attachment(n, "", d) for n, d in log.attachments().items()]
    copy = McapLog(target, custom_data=log.custom_data, attachments=attachments)
    ids: dict[str, int] = {}
    for m in log.messages():
        if m.topic.endswith("/state_hash") and m.log_time > last * 1e9:
            continue
        if m.topic not in ids:
            ids[m.topic] = copy.add_topic(m.topic, m.type, Qos())
        copy.write([Entry(ids[m.topic], m.log_time, m.step, m.data)])
    copy.close({"steps": "230"})


def test_a_bag_without_hashes_is_not_called_identical(tmp_path):
    record_eventful(tmp_path / "run")
    with_hashes_until(tmp_path / "run", tmp_path / "bare", -1.0)
    with pytest.raises(RecordingError, match="no state hashes"):
        verify(tmp_path / "bare")


def test_what_is_lost_is_told(tmp_path):
    record_eventful(tmp_path / "run")
    with_hashes_until(tmp_path / "run", tmp_path / "part", 0.2)
    result = verify(tmp_path / "part")
    assert result.difference is None
    assert 0 < result.steps < 230
    assert f"230 steps were made, the recording holds {result.steps} of them" in result.text


@pytest.mark.parametrize("start", [-1.0, 50.0, float("nan")])
def test_a_start_outside_the_recording_is_refused(tmp_path, start):
    record_eventful(tmp_path / "run")
    with pytest.raises(RecordingError, match="goes from 0 to 0.46 s"):
        verify(tmp_path / "run", start=start)
    with pytest.raises(RecordingError, match="start is"):
        branch(tmp_path / "run", tmp_path / "b", start=start)


@pytest.mark.parametrize(("start", "steps"), [(0.0, 230), (0.15, 180), (0.31, 80)])
def test_it_can_start_at_a_snapshot(tmp_path, start, steps):
    record_eventful(tmp_path / "run")
    result = verify(tmp_path / "run", start=start)
    assert result.difference is None, result.text
    assert result.steps == steps


def test_one_flipped_bit_of_one_input_is_found_and_named(tmp_path):
    record_eventful(tmp_path / "run")

    def flip(message):
        if message.topic == "/sim_node/operations" and b'"apply_impulse"' in message.data:
            return message.data.replace(b"[0.1, 0", b"[0.3, 0")  # one bit of the digit
        return message.data

    rewritten(tmp_path / "run", tmp_path / "changed", flip)
    result = verify(tmp_path / "changed")
    assert result.difference is not None
    assert result.difference.step == 121  # the first step after it
    assert result.difference.body == "crate"
    assert result.difference.quantity == "position"
    assert result.difference.seen_step == 125  # the first logged poses from there on
    assert "differs from step 121 on" in result.text
    assert "body crate: position recorded [" in result.text


def test_one_flipped_bit_of_the_scene_is_found(tmp_path):
    record_eventful(tmp_path / "run")
    log = Recording(tmp_path / "run")
    scene = log.attachments()["scene.yaml"].replace(b"restitution: 0.5", b"restitution: 0.4")
    attachments = [Attachment("scene.yaml", "", scene)]
    attachments += [Attachment(n, "", d) for n, d in log.attachments().items() if n != "scene.yaml"]
    copy = McapLog(tmp_path / "changed", custom_data=log.custom_data, attachments=attachments)
    ids: dict[str, int] = {}
    for m in log.messages():
        if m.topic not in ids:
            ids[m.topic] = copy.add_topic(m.topic, m.type, Qos())
        copy.write([Entry(ids[m.topic], m.log_time, m.step, m.data)])
    copy.close()
    result = verify(tmp_path / "changed")
    assert result.difference is not None


def test_differences_of_version_are_said_first(tmp_path):
    record_eventful(tmp_path / "run")
    log = Recording(tmp_path / "run")
    notes = log.custom_data | {"cpu": "Abacus 1"}
    copy = McapLog(
        tmp_path / "copy", custom_data=notes,
        attachments=[Attachment(n, "", d) for n, d in log.attachments().items()],
    )  # fmt: skip
    ids: dict[str, int] = {}
    for m in log.messages():
        if m.topic not in ids:
            ids[m.topic] = copy.add_topic(m.topic, m.type, Qos())
        copy.write([Entry(ids[m.topic], m.log_time, m.step, m.data)])
    copy.close()
    text = verify(tmp_path / "copy").text.splitlines()
    assert text[0].startswith("recorded with cpu Abacus 1, repeated with ")
    assert text[-1].startswith("identical")


def test_a_run_of_several_files_and_several_threads(tmp_path):
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene, split_duration=0.1) as recorder:
        run_steps(world, recorder, 200)
    assert len(list((tmp_path / "run").glob("*.mcap"))) == 5
    assert verify(tmp_path / "run", threads=2).text.endswith("identical, 200 steps, 0.4 s")


def test_recordings_that_cannot_be_repeated_say_why(tmp_path):
    world = rb.World()
    world.add_body(rb.Sphere(0.1), mass=1.0)
    with Recorder(world, tmp_path / "built") as recorder:
        run_steps(world, recorder, 3)
    with pytest.raises(RecordingError, match="holds no scene"):
        verify(tmp_path / "built")
    foreign = McapLog(tmp_path / "foreign")
    foreign.close()
    with pytest.raises(RecordingError, match="not made by rb_physics"):
        verify(tmp_path / "foreign")
    newer = McapLog(tmp_path / "newer", custom_data={"format_version": "99"})
    newer.close()
    with pytest.raises(RecordingError, match="format version 99"):
        verify(tmp_path / "newer")
    with pytest.raises(RecordingError, match="does not exist"):
        verify(tmp_path / "nothing")


def test_hostile_metadata_is_refused(tmp_path):
    record_eventful(tmp_path / "run")
    path = tmp_path / "run" / "metadata.yaml"
    content = yaml.safe_load(path.read_text())
    for name in ("../other.mcap", "/etc/passwd", "run_0.mcap/../x.mcap", "notes.txt"):
        content["rosbag2_bagfile_information"]["relative_file_paths"] = [name]
        path.write_text(yaml.safe_dump(content))
        with pytest.raises(RecordingError, match="not an .mcap file of"):
            Recording(tmp_path / "run")
    for text in ("[1, 2]", "!!python/object/apply:os.getcwd []", "a: [", "rosbag2_bagfile_information: 3",
                 "rosbag2_bagfile_information: {relative_file_paths: 7}"):  # fmt: skip
        path.write_text(text)
        with pytest.raises(RecordingError):
            Recording(tmp_path / "run")
    path.unlink()
    assert verify(tmp_path / "run").difference is None  # the files alone are enough


def test_notes_hold_the_settings(tmp_path):
    record_eventful(tmp_path / "run")
    settings = json.loads(Recording(tmp_path / "run").custom_data["settings"])
    assert settings["dt"] == 0.002
    assert settings["stepper"] == "fixed"


@pytest.mark.parametrize("name", packaged_scenes())
def test_every_packaged_scene_repeats(tmp_path, name):
    scene = rb.load_scene(name)
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for _ in range(15):
            world.step(10)
            recorder.after_step()
    assert verify(tmp_path / "run", threads=2).difference is None
