"""Outputs and recorder on a real world: values, means, resets, failures."""

from __future__ import annotations

import builtins
import json
import sys

import numpy as np
import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError, TopicTable, load_topics, operations
from rb_physics.recording.decoders import (
    decode_multi_array,
    decode_point_cloud,
    decode_pose_array,
    decode_string,
    decode_transforms,
    decode_wrench_stamped,
)
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.topics import parse_topics

SCENE = """
dt: 0.001
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - name: box
    shape: {type: box, half_extents: [0.1, 0.1, 0.1]}
    mass: 2.0
    position: [0, 0, 0.1]
    frames: {tip: {position: [0.1, 0, 0], orientation: [0, 0, 0, 1]}}
  - {name: ball, shape: {type: sphere, radius: 0.05}, mass: 0.5, position: [1, 0, 0.3], restitution: 0.5}
"""
WEIGHT = 2.0 * 9.81


def build() -> tuple:
    scene = rb.Scene.from_yaml(SCENE, name="test")
    return scene, scene.build()


def topic(log: Recording, name: str) -> list:
    return list(log.messages({name}))


def test_contact_wrench_is_the_mean_over_its_interval(tmp_path):
    scene, world = build()
    impulse = np.zeros(3)
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for _ in range(500):
            world.step()
            impulse += world.contact_wrenches[2, 0] * 1e-3
            recorder.after_step()
    log = Recording(tmp_path / "run")
    messages = topic(log, "/sim_node/bodies/ball/contact_wrench")
    assert [m.log_time for m in messages] == [k * 10_000_000 for k in range(51)]
    wrenches = [decode_wrench_stamped(m.data) for m in messages]
    assert {w.frame_id for w in wrenches} == {"ball/com"}
    assert impulse[2] > 0.5  # the ball has bounced: its momentum was about 1 N s before
    logged = sum(w.values[2] * 0.01 for w in wrenches)
    # The ball doesn't turn, so its axes are the world's. 50 additions of rounding.
    assert abs(logged - impulse[2]) < 1e-12
    box = decode_wrench_stamped(topic(log, "/sim_node/bodies/box/contact_wrench")[-1].data)
    assert abs(box.values[2] - WEIGHT) < 1e-9 * WEIGHT  # the contact solver's tolerance


def frames_table(frame: str) -> TopicTable:
    return parse_topics(
        "topics: [{name: ~/bodies/NAME/contact_wrench, content: contact_wrench, rate: 0, type: "
        f"geometry_msgs/msg/WrenchStamped, direction: out, frame: {frame}, bodies: [box]}}]"
    )


@pytest.mark.parametrize("frame", ["NAME", "NAME/com", "world"])
def test_contact_wrench_in_each_frame(frame):
    world = rb.World()
    world.add_body(rb.HalfSpace(), type="static", name="ground")
    turned = np.array([0.0, 0.0, np.sin(0.4), np.cos(0.4)])
    box = world.add_body(
        rb.Box((0.1, 0.1, 0.1)), mass=1.0, name="box", position=(0, 0, 0.1), orientation=turned,
        center_of_mass=(0.05, 0.0, 0.0),
    )  # fmt: skip
    box.apply_wrench(force=(1.0, 0, 0))
    recorder = Recorder(world, None, topics=frames_table(frame))
    world.step(10)
    recorder.after_step()
    world.step()
    [(_, data)] = recorder.after_step()
    wrench = decode_wrench_stamped(data)
    force, torque = world.contact_wrenches[1]
    q = world.orientations[1]
    rotation = rb.math.rotation_matrix(q)
    if frame == "NAME":
        torque = torque + np.cross(world.com_positions[1] - world.positions[1], force)
    if frame != "world":
        force, torque = rotation.T @ force, rotation.T @ torque
    assert wrench.frame_id == frame.replace("NAME", "box")
    # Same numbers by other arithmetic: a few roundings of 10 N.
    assert np.allclose(wrench.values, [*force, *torque], atol=1e-13)


def test_everything_a_view_needs_is_in_the_bag(tmp_path):
    scene, world = build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for _ in range(100):
            world.step()
            recorder.after_step()
        positions = world.positions
    log = Recording(tmp_path / "run")
    names = json.loads(decode_string(topic(log, "/sim_node/body_names")[0].data))
    assert names == ["ground", "box", "ball"]
    time_ns, frame, poses = decode_pose_array(topic(log, "/sim_node/poses")[-1].data)
    assert (time_ns, frame) == (100_000_000, "world")
    assert np.array_equal(poses[:, :3], positions)
    points = decode_point_cloud(topic(log, "/sim_node/contacts")[-1].data)[2]
    assert len(points) == 4
    assert set(points["body_a"]) == {1}
    assert set(points["body_b"]) == {0}
    assert abs(points["fz"].sum() - WEIGHT) < 1e-5 * WEIGHT  # float32 in the cloud
    transforms = decode_transforms(topic(log, "/tf_static")[0].data)
    assert ("box", "box/tip", (0.1, 0, 0, 0, 0, 0, 1)) in [t[1:] for t in transforms]
    assert {t[2] for t in transforms} == {"ground/com", "box/com", "ball/com", "box/tip"}
    assert log.attachments()["scene.yaml"].decode() == SCENE
    assert log.custom_data["steps"] == "100"
    assert log.custom_data["dropped"] == "0"


def test_hash_of_every_step_and_snapshots(tmp_path):
    scene, world = build()
    hashes = []
    with Recorder(world, tmp_path / "run", scene=scene, snapshot_interval=0.1) as recorder:
        for count in (1, 2, 1, 46, 100, 150):
            world.step(count)
            hashes.append((recorder.step + count, world.state_hash))
            recorder.after_step()
    log = Recording(tmp_path / "run")
    rows = np.concatenate(
        [decode_multi_array(m.data, "u8")[1] for m in topic(log, "/sim_node/state_hash")]
    )
    assert rows[:, 0].tolist() == list(range(1, 301))
    logged = dict(rows.tolist())
    assert all(logged[step] == value for step, value in hashes)
    snapshots = topic(log, "/sim_node/snapshots")
    assert [m.step for m in snapshots] == [0, 150, 300]
    (label,), data = decode_multi_array(snapshots[1].data, "u1")
    assert label == "step 150"
    again = scene.build()
    again.restore(data.tobytes())
    assert again.state_hash == logged[150]


def test_log_time_never_goes_back(tmp_path):
    scene, world = build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for name in ("reset", "reset_state", "reset"):
            for _ in range(50):
                world.step()
                recorder.after_step()
            recorder.perform(name)
            assert world.time == (0.0 if name == "reset" else 0.05)
            assert world["ball"].position[2] == 0.3
        world.step()
        recorder.after_step()
    log = Recording(tmp_path / "run")
    times = [m.log_time for m in log.messages()]
    assert times == sorted(times)
    assert times[-1] == 151_000_000
    stamps = [decode_pose_array(m.data)[0] for m in topic(log, "/sim_node/poses")]
    assert stamps[-1] == 10_000_000 * 10  # header.stamp is simulated time; none is due yet after it
    assert [operations.from_json(decode_string(m.data))[:2] for m in
            topic(log, "/sim_node/operations")] == [(50, "reset"), (100, "reset_state"),
                                                     (150, "reset")]  # fmt: skip
    assert len(topic(log, "/sim_node/events")) == 3


def test_operations_are_done_and_logged_to_the_bit(tmp_path):
    scene, world = build()
    force = np.array([0.1 + 0.2, 1e-300, -0.0])
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        recorder.perform("apply_wrench", body="box", force=force, torque=(0, 0, 0), duration=0.5)
        world.step()
        recorder.after_step()
        recorder.perform("set_state", body="ball", position=(1, 2, 3))
        recorder.perform("clear_wrenches")
        recorder.perform("apply_impulse", body="ball", impulse=(1, 0, 0))
        with pytest.raises(rb.SceneError):
            recorder.perform("apply_wrench", body="ground", force=(1, 0, 0))
        with pytest.raises(ValueError, match="unknown operation 'fly'"):
            recorder.perform("fly")
        with pytest.raises(ValueError, match=r"not JSON compliant|out of range"):
            recorder.perform("apply_wrench", body="box", force=(np.nan, 0, 0))
        assert world["ball"].linear_velocity[0] == 2.0
    logged = [operations.from_json(decode_string(m.data))
              for m in topic(Recording(tmp_path / "run"), "/sim_node/operations")]  # fmt: skip
    assert [(op.step, op.name) for op in logged] == [
        (0, "apply_wrench"), (1, "set_state"), (1, "clear_wrenches"), (1, "apply_impulse"),
    ]  # fmt: skip
    assert np.array(logged[0].arguments["force"]).tobytes() == force.tobytes()


def test_bodies_come_and_go(tmp_path):
    scene, world = build()
    crate = {"name": "crate", "shape": {"type": "sphere", "radius": 0.1}, "mass": 1.0,
             "position": [3, 0, 1]}  # fmt: skip
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        recorder.perform("add_body", description=crate)
        for _ in range(20):
            world.step()
            recorder.after_step()
        recorder.perform("remove_body", body="box")
        for _ in range(20):
            world.step()
            recorder.after_step()
    log = Recording(tmp_path / "run")
    assert len(topic(log, "/sim_node/bodies/crate/contact_wrench")) > 0
    counts = [len(decode_pose_array(m.data)[2]) for m in topic(log, "/sim_node/poses")]
    assert counts == [3, 4, 4, 3, 3]
    names = [json.loads(decode_string(m.data)) for m in topic(log, "/sim_node/body_names")]
    assert names[-1] == ["ground", "ball", "crate"]


def test_inputs_are_logged_with_their_step(tmp_path):
    scene, world = build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        world.step(7)
        recorder.after_step()
        recorder.write_input("/sim_node/bodies/box/wrench", b"\0\1\0\0raw")
        with pytest.raises(ValueError, match="/nowhere is not in the table"):
            recorder.write_input("/nowhere", b"")
    [message] = topic(Recording(tmp_path / "run"), "/sim_node/bodies/box/wrench")
    assert (message.step, message.log_time, message.data) == (7, 7_000_000, b"\0\1\0\0raw")


def test_same_run_same_messages(tmp_path):
    def messages(name: str) -> list:
        scene, world = build()
        with Recorder(world, tmp_path / name, scene=scene) as recorder:
            for _ in range(200):
                world.step()
                recorder.after_step()
        return [m for m in Recording(tmp_path / name).messages() if "state_hash" not in m.topic]

    assert messages("a") == messages("b")


def test_without_a_folder_outputs_still_come():
    _, world = build()
    recorder = Recorder(world, None)
    assert recorder.steps_until_due() == 10
    world.step(10)
    names = [name for name, _ in recorder.after_step()]
    assert "/clock" in names
    assert "/sim_node/poses" in names
    assert "/sim_node/diagnostics" not in names  # once a second
    assert {name for name, _ in recorder.latched()} == {
        "/sim_node/body_names", "/tf_static", "/robot_description",
    }  # fmt: skip
    recorder.perform("reset")
    recorder.event("INFO", "nothing is recorded")
    assert (recorder.counters, recorder.error, recorder.directory) == ({}, None, None)
    recorder.close()


@pytest.mark.parametrize("dt", [1e-3, 1 / 240, 3e-3, 0.02])
def test_rates_hold_for_any_step(dt):
    world = rb.World(dt=dt)
    world.add_body(rb.Sphere(0.1), mass=1.0, name="ball")
    recorder = Recorder(world, None)
    count = 0
    while world.time < 2.0 - dt / 2:
        world.step(recorder.steps_until_due())
        count += sum(name == "/clock" for name, _ in recorder.after_step())
    assert abs(count - 2.0 * min(100.0, 1 / dt)) <= 1


def test_missing_rerun_says_what_to_do(tmp_path, monkeypatch):
    real_import = builtins.__import__

    def no_rerun(name, *arguments, **keywords):
        if name.split(".")[0] == "rerun":
            raise ImportError(name)
        return real_import(name, *arguments, **keywords)

    for name in [n for n in sys.modules if n.split(".")[0] == "rerun"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", no_rerun)
    scene, world = build()
    with pytest.raises(RecordingError, match="pip install rerun-sdk"):
        Recorder(world, tmp_path / "run", scene=scene, rerun="file")
    assert not (tmp_path / "run").exists()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        world.step(10)
        recorder.after_step()
    assert (tmp_path / "run" / "run_0.mcap").is_file()


@pytest.mark.parametrize("rerun", ["on", ""])
def test_unknown_rerun_choice(tmp_path, rerun):
    _, world = build()
    with pytest.raises(RecordingError, match="must be off, file or live"):
        Recorder(world, tmp_path / "run", rerun=rerun)


def test_existing_folder_is_refused(tmp_path):
    _, world = build()
    with pytest.raises(RecordingError, match="never overwritten"):
        Recorder(world, tmp_path)


def test_default_table_expands_for_any_names():
    world = rb.World()
    world.add_body(rb.Sphere(0.1), mass=1.0, name="NAME")
    recorder = Recorder(world, None, topics=load_topics())
    assert "/sim_node/bodies/NAME/contact_wrench" in {t.name for t in recorder.outputs.topics}
