"""Disks that fill, turn read-only or vanish: the run goes on, and what was written is read back."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time

import pytest
import yaml

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.mcap_log import McapLog
from rb_physics.recording.recover import recover
from rb_physics.recording.replay import verify
from rb_physics.recording.summary import summary

STEPS = 4000


def run(directory, at_step=None, act=None, **options):
    """Steps a hundred bodies, whatever happens to the log; the recorder and the world.

    They are thrown up, each in its own way: what rests takes no room on a disk, so well is it compressed.
    """
    scene = rb.load_scene("hundred_bodies")
    world = scene.build()
    for k, body in enumerate(world.bodies):
        if body.type == "dynamic":
            body.linear_velocity = (0.01 * (k % 7), 0.01 * (k % 11), 8.0)
            body.angular_velocity = (1.0, 0.1 * k, 3.0)
    recorder = Recorder(world, directory, scene=scene, **options)
    for step in range(STEPS):
        if step == at_step:
            act()
        if recorder.error is not None and step % 50 == 0:
            break
        world.step()
        recorder.after_step()
    recorder.close()
    return recorder, world


@pytest.mark.parametrize("rerun", ["off", "file"])
def test_a_full_disk_ends_in_a_whole_bag(small_disk, rerun):
    if rerun == "file":
        pytest.importorskip("rerun")
    mount, _ = small_disk
    recorder, world = run(mount / "run", rerun=rerun)
    assert "is full" in recorder.error
    assert world.step_count > 200  # 4 MB hold half a second and more
    assert recorder.counters["dropped"] > 0
    recording = Recording(mount / "run")
    assert len(list(recording.messages())) > 1000
    assert recording.torn == []
    assert "stopped early: disk full" in summary(mount / "run")
    assert verify(mount / "run").difference is None


def test_a_disk_that_is_full_already_is_refused(small_disk):
    mount, _ = small_disk
    filler = mount / "filler"
    filled = subprocess.run(["dd", "if=/dev/zero", f"of={filler}", "bs=4k"], capture_output=True)
    assert b"No space left" in filled.stderr
    world = rb.load_scene("single_box").build()
    try:
        recorder = Recorder(world, mount / "run")
    except RecordingError as error:
        assert "No space left" in str(error)
    else:
        for _ in range(100):
            world.step()
            recorder.after_step()
        recorder.close()
        assert "full" in recorder.error or "No space left" in recorder.error


def test_a_disk_that_turns_read_only_leaves_what_can_be_recovered(small_disk, tmp_path):
    mount, remount = small_disk
    # The open file must be let go of by the kernel: a lazy remount makes further writes fail.
    real, broken = os.write, []

    def write(descriptor, data):
        if broken:
            raise OSError(30, "Read-only file system")
        return real(descriptor, data)

    os.write = write
    try:
        recorder, _ = run(mount / "run", 300, lambda: broken.append(True))
    finally:
        os.write = real
    assert "Read-only file system" in recorder.error
    assert "rb_physics recover" in recorder.error
    remount("ro")
    try:
        with pytest.raises(RecordingError, match=r"can't be made \(Read-only file system\)"):
            recover(mount / "run")
        with pytest.raises(RecordingError, match=r"can't be made \(Read-only file system\)"):
            Recorder(rb.World(), mount / "another")
        copy = tmp_path / "run"
        subprocess.run(["cp", "-r", str(mount / "run"), str(copy)], check=True)
    finally:
        remount("rw")
    assert recover(copy).messages > 500
    result = verify(tmp_path / "run_recovered")
    assert result.difference is None
    assert result.steps > 100


def test_a_folder_that_is_removed_at_a_split_ends_in_a_sentence(tmp_path):
    def remove():
        while (tmp_path / "run").exists():
            # A file that begins meanwhile leaves the folder not empty: once more.
            with contextlib.suppress(OSError):
                shutil.rmtree(tmp_path / "run")

    recorder, world = run(tmp_path / "run", 300, remove, split_duration=0.05)
    assert "was removed while it was recorded to; nothing is left" in recorder.error
    assert world.step_count < STEPS  # `run` stops when it is told
    assert not (tmp_path / "run").exists()


def test_a_file_that_is_removed_leaves_those_before_it(tmp_path):
    folder = tmp_path / "run"

    def remove():
        time.sleep(0.2)  # the file of the last steps is there
        (folder / "run_2.mcap").unlink()

    recorder, _ = run(folder, 290, remove, split_duration=0.1)
    assert "run_2.mcap was removed while it was written" in recorder.error
    listed = yaml.safe_load((folder / "metadata.yaml").read_text("utf-8"))
    counts = listed["rosbag2_bagfile_information"]
    messages = sum(topic["message_count"] for topic in counts["topics_with_message_count"])
    assert messages == counts["message_count"] == recorder.counters["messages"]
    assert len(list(Recording(folder).messages())) == messages
    result = verify(folder)
    assert result.difference is None
    assert result.steps >= 180  # two files of 100 steps, and 20 for hashes in the next one
    assert "stopped early: file removed" in summary(folder)


def test_a_file_that_is_moved_away_is_whole(tmp_path):
    folder = tmp_path / "run"
    recorder, _ = run(folder, 300, lambda: os.rename(folder / "run_0.mcap", tmp_path / "gone.mcap"))
    assert "run_0.mcap was moved away while it was written; it is whole" in recorder.error
    os.rename(tmp_path / "gone.mcap", folder / "run_0.mcap")
    result = verify(folder)
    assert result.difference is None
    assert result.steps >= 300


def test_every_message_is_counted_as_written_or_dropped(small_disk):
    mount, _ = small_disk
    given = []
    put = McapLog.write
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(McapLog, "write", lambda log, e: (given.extend(e), put(log, e))[1])
        recorder, _ = run(mount / "run")
    assert recorder.counters["messages"] == len(list(Recording(mount / "run").messages()))
    assert recorder.counters["messages"] + recorder.counters["dropped"] == len(given)


def test_a_recovery_without_room_leaves_nothing_behind(small_disk):
    mount, _ = small_disk
    recorder, _ = run(mount / "run")
    assert "is full" in recorder.error
    with pytest.raises(RecordingError, match=r"can't be written \(No space left on device\)"):
        recover(mount / "run")
    assert sorted(p.name for p in mount.iterdir()) == ["run"]
