"""A disk too small for anything: the run was told to recover a recording that held no message. And what
failed in the last moment of a run or of a branch went unsaid."""

import shutil

import pytest
from click.testing import CliRunner

import rb_physics as rb
from rb_physics import cli
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.bag_file import BagFile
from rb_physics.recording.branch import branch
from rb_physics.recording.recover import recover
from rb_physics.recording.replay import verify


def call(*arguments):
    return CliRunner().invoke(cli.main, list(map(str, arguments))).output


@pytest.mark.parametrize("size", range(100, 340, 20))  # kB: from a refusal on to a first chunk
def test_a_sentence_that_is_true(small_disk, tmp_path, size):
    mount, remount = small_disk
    remount(f"size={size}k")
    scene, folder = rb.load_scene("hundred_bodies"), mount / "run"
    world = scene.build()
    try:
        recorder = Recorder(world, folder, scene=scene)
    except RecordingError as error:
        assert "are needed to begin; free some space" in str(error)
        assert not folder.exists()
        return
    with recorder:
        for _ in range(600):  # more than any of these disks holds
            world.step()
            recorder.after_step()
    assert recorder.counters["dropped"] > 0
    shutil.copytree(folder, tmp_path / "run")
    if "nothing of the run could be kept" in recorder.error:
        assert recorder.counters["messages"] == 0
        assert "holds no messages" in call("info", tmp_path / "run")
    elif "can be read after `rb_physics recover" in recorder.error:
        assert recover(tmp_path / "run").messages == recorder.counters["messages"] > 0
    else:
        assert "kept and readable" in recorder.error
        assert "finished, stopped early: disk full" in call("info", tmp_path / "run")
        assert recorder.counters["messages"] > 0
        try:
            assert verify(tmp_path / "run").difference is None
        except RecordingError as error:  # full after the first messages, before a first hash
            assert "holds no state hashes" in str(error)


@pytest.fixture
def full_at_the_end(monkeypatch):
    def finish(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(BagFile, "finish", finish)


def test_the_last_moment_of_a_run(tmp_path, full_at_the_end):
    output = call("run", "demo", "--duration", "0.01", "--record", tmp_path / "run", "--no-rerun")
    assert "Error: the run ended at 0.01 s: recording stopped" in output


def test_the_last_moment_of_a_branch(tmp_path, request):
    scene = rb.load_scene("demo")
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene) as recorder:
        for _ in range(100):
            world.step()
            recorder.after_step()
    request.getfixturevalue("full_at_the_end")
    with pytest.raises(RecordingError, match=r"the branch ended at 0.1 s: recording stopped"):
        branch(tmp_path / "run", tmp_path / "branch", start=0.05, rerun="off")
