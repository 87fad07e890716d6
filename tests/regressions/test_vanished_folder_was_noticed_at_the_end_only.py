"""A folder removed or renamed during the run was noticed when the log was closed, hours later perhaps,
and the sentence sent people to `recover` a folder that wasn't there."""

import os
import shutil
import time

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.replay import verify
from rb_physics.recording.summary import summary

SOON = 1.5  # s of wall time: looked at twice a second, and a busy machine


def recorded(folder, change):
    """Steps with a recorder whose folder changes under it, until it tells; the recorder and s until then."""
    scene = rb.load_scene("demo")
    world = scene.build()
    with Recorder(world, folder, scene=scene) as recorder:
        changed, end = None, time.monotonic() + 20
        while recorder.error is None and time.monotonic() < end:
            world.step()
            recorder.after_step()
            if changed is None and recorder.step == 300:
                time.sleep(0.1)
                change()
                changed = time.monotonic()
            time.sleep(1e-4)
        took = time.monotonic() - changed
    return recorder, took


def test_a_removed_folder(tmp_path):
    folder = tmp_path / "run"
    recorder, took = recorded(folder, lambda: shutil.rmtree(folder))
    assert took < SOON
    assert recorder.error == (
        f"recording stopped: the folder {folder} was removed while it was recorded to; nothing is left "
        "of the recording there"
    )
    assert recorder.counters["messages"] == recorder.counters["file_bytes"] == 0
    assert recorder.counters["dropped"] > 300
    assert not folder.exists()


def test_a_renamed_folder(tmp_path):
    folder, other = tmp_path / "run", tmp_path / "other"
    recorder, took = recorded(folder, lambda: os.rename(folder, other))
    assert took < SOON
    assert (
        f"{folder} was moved or renamed while it was recorded to; everything up to"
        in recorder.error
    )
    assert recorder.error.endswith(f"kept and readable in {other}")
    assert not folder.exists()
    result = verify(other)
    assert result.difference is None
    assert result.steps >= 300
    assert "finished, stopped early: folder moved" in summary(other)


def test_the_name_taken_by_another_recording(tmp_path):
    """The one that lost its folder wrote its metadata.yaml over the other's."""
    folder = tmp_path / "run"
    others = []

    def replace():
        shutil.rmtree(folder)
        scene = rb.load_scene("single_box")
        others.append(Recorder(scene.build(), folder, scene=scene))

    recorder, _ = recorded(folder, replace)
    assert "was removed while it was recorded to" in recorder.error
    others[0].close()
    assert others[0].error is None
    assert "scene       single_box" in summary(folder)


@pytest.mark.parametrize("to", [".", ".."])
def test_another_working_directory_is_no_move(tmp_path, monkeypatch, to):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    scene = rb.load_scene("single_box")
    with Recorder(scene.build(), "run", scene=scene) as recorder:
        os.chdir(tmp_path / "elsewhere" / to)
        time.sleep(0.8)  # it looks twice a second
    assert recorder.error is None
    assert verify(tmp_path / "run").difference is None
