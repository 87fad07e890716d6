"""The committed samples stay readable: of today's format version, and of older ones."""

from __future__ import annotations

from pathlib import Path

import pytest

import rb_physics as rb
from rb_physics.recording import RecordingError
from rb_physics.recording.compare import compare
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.recorder import FORMAT_VERSION
from rb_physics.recording.replay import Run, verify
from rb_physics.recording.summary import summary
from rb_physics.recording.tables import read_tables

SAMPLE = Path(__file__).resolve().parents[2] / "recordings" / "sample"
OLDER = Path(__file__).parent / "format_1"

if not SAMPLE.is_dir():
    pytest.skip("needs the source tree", allow_module_level=True)


@pytest.mark.parametrize("sample", [SAMPLE, OLDER])
def test_summary(sample):
    text = summary(sample)
    assert "0.000 to 1.000 s, 1000 steps of 0.001 s" in text
    assert "state       finished" in text
    assert "/sim_node/bodies/NAME/contact_wrench" in text


def test_everything_a_repetition_needs_can_be_read():
    run = Run(SAMPLE)
    assert run.notes["format_version"] == str(FORMAT_VERSION)
    assert run.steps.tolist() == list(range(1, 1001))
    assert list(run.snapshots) == [0]
    assert sorted(run.poses) == list(range(0, 1001, 10))
    world = rb.Scene.from_yaml(run.scene_text).build()
    assert [body.name for body in world.bodies] == ["ground", "ball"]


def test_the_ball_bounces_as_it_should():
    poses = Run(SAMPLE).poses
    # 1 m of fall from rest: at 0.4 s the height above the start of the fall is -g t^2 / 2.
    fallen = poses[0][1, 2] - poses[400][1, 2]
    assert abs(fallen - 0.5 * 9.81 * 0.4**2) < 1e-12


def test_rosbags_reads_it():
    anyreader = pytest.importorskip("rosbags.highlevel")
    with anyreader.AnyReader([SAMPLE]) as reader:
        assert reader.message_count == len(list(Recording(SAMPLE).messages()))


@pytest.mark.parametrize("sample", [SAMPLE, OLDER])
def test_the_view_can_be_made_again(tmp_path, sample):
    pytest.importorskip("rerun")
    from rb_physics.recording.render import write_rrd

    assert write_rrd(sample, tmp_path / "sample.rrd").stat().st_size > 100_000


def test_format_1_is_read_but_says_that_it_cannot_be_repeated():
    ball = read_tables(OLDER).poses
    # Both were made from one scene; before the ball first lands physics is the same to rounding.
    assert compare(OLDER, SAMPLE).end == 1.0
    assert abs(ball["position"][ball["body"] == 1][40, 2] - (1.1 - 0.5 * 9.81 * 0.16)) < 1e-12
    with pytest.raises(RecordingError, match="format version 1, whose state hashes .*no longer"):
        verify(OLDER)
