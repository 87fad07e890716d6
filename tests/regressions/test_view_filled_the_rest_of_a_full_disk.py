"""When the bag stopped for a full disk, the .rrd went on to fill the room the bag had left; the Rerun
library then waited for its own dead writer, now and then for ever."""

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.replay import verify


def test_the_view_ends_with_the_bag(small_disk):
    chunks = pytest.importorskip("rerun.chunk")
    mount, _ = small_disk
    scene = rb.load_scene("hundred_bodies")
    world = scene.build()
    with Recorder(world, mount / "run", scene=scene, rerun="file") as recorder:
        while recorder.error is None:
            world.step()
            recorder.after_step()
        stopped = world.time
        for _ in range(2000):  # these alone would fill what is left
            world.step()
            recorder.after_step()
    assert "is full" in recorder.error
    assert recorder.view_error is None
    assert verify(mount / "run").difference is None
    seen = 0.0
    for chunk in chunks.RrdReader(mount / "run" / "run.rrd").stream():
        batch = chunk.to_record_batch()
        if "sim_time" in batch.schema.names and batch.num_rows:
            seen = max(seen, max(batch.column("sim_time").cast("int64").to_pylist()) * 1e-9)
    assert 0.1 < seen <= stopped + 1e-9


def test_a_disk_that_is_too_small_for_a_view(small_disk):
    pytest.importorskip("rerun")
    mount, remount = small_disk
    remount("size=500k")
    with pytest.raises(RecordingError, match="1200 kB are needed to begin"):
        Recorder(rb.World(), mount / "run", rerun="file")
    assert list(mount.iterdir()) == []
    with Recorder(rb.World(), mount / "run"):
        pass
