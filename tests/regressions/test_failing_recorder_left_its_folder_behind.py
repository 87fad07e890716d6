"""A recorder that could not begin left an open file and its folder, so that trying again was refused:
"exists already"."""

import os

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.rerun_log import RerunLog


def descriptors():
    return sorted(os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd")
                  if os.path.exists(f"/proc/self/fd/{n}"))  # fmt: skip


@pytest.mark.parametrize("size", ["8k", "16k", "64k"])
def test_on_a_disk_without_room(small_disk, size):
    mount, remount = small_disk
    remount(f"size={size}")
    world = rb.load_scene("single_box").build()
    before = descriptors()
    with pytest.raises(RecordingError, match="free some space"):
        Recorder(world, mount / "run")
    assert descriptors() == before
    assert list(mount.iterdir()) == []
    remount("size=4m")
    with Recorder(world, mount / "run") as recorder:  # another try, under the same name
        world.step()
        recorder.after_step()
    assert recorder.error is None


def test_with_an_operation_that_is_refused(tmp_path):
    world = rb.load_scene("single_box").build()
    before = descriptors()
    with pytest.raises(KeyError):
        Recorder(world, tmp_path / "run", first=[("remove_body", {"body": "nobody"})])
    assert descriptors() == before
    assert list(tmp_path.iterdir()) == []


def test_with_a_view_that_fails(tmp_path, monkeypatch):
    pytest.importorskip("rerun")

    def fail(*_, **__):
        (tmp_path / "run" / "run.rrd").write_bytes(b"begun")
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(RerunLog, "__init__", fail)
    with pytest.raises(OSError, match="Input/output error"):
        Recorder(rb.World(), tmp_path / "run", rerun="file")
    assert list(tmp_path.iterdir()) == []


def test_what_others_put_there_stays(tmp_path, monkeypatch):
    pytest.importorskip("rerun")

    def fail(*_, **__):
        (tmp_path / "run" / "notes.txt").write_text("mine")
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(RerunLog, "__init__", fail)
    with pytest.raises(OSError, match="Input/output error"):
        Recorder(rb.World(), tmp_path / "run", rerun="file")
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["notes.txt"]
