"""verify on recordings with a damaged chunk: what is there is compared, what is missing is told."""

from __future__ import annotations

import re
import shutil

import pytest
from push_and_drop import SCENE

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.branch import branch
from rb_physics.recording.lost_spans import LostSpan, from_json, merged, to_json
from rb_physics.recording.mcap_reader import read_summary
from rb_physics.recording.recover import recover
from rb_physics.recording.replay import verify

STEPS = 400
CRATE = {"name": "crate", "shape": {"type": "box", "half_extents": [0.1, 0.1, 0.1]}, "mass": 1.0,
         "position": [0.5, 0.5, 0.4]}  # fmt: skip


def record(directory, every: int, changes=()) -> None:
    """400 steps; `changes`: step -> operation. A push every so many steps; chunks of a few steps."""
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    planned = dict(changes)
    with Recorder(
        world, directory, scene=scene, snapshot_interval=0.2, chunk_bytes=8000
    ) as recorder:
        for step in range(STEPS):
            if step % every == every // 2:
                recorder.perform("apply_impulse", body="box", impulse=(0.01, 0, 0))
            for name, arguments in planned.get(step, ()):
                recorder.perform(name, **arguments)
            world.step()
            recorder.after_step()


def chunks(bag):
    with open(bag, "rb") as file:
        return read_summary(file).chunks


def damaged(source, target, place):
    """A copy with a flipped bit in a chunk."""
    shutil.copytree(source, target)
    bag = target / f"{source.name}_0.mcap"
    data = bytearray(bag.read_bytes())
    data[place.offset + place.length // 2] ^= 1
    bag.write_bytes(data)
    return target


def covered(text: str) -> list[tuple[float, float]]:
    return [(float(a), float(b)) for a, b in re.findall(r"lost from (\S+) to (\S+) s", text)]


@pytest.mark.parametrize("every", [7, 10_000], ids=["pushed", "left alone"])
def test_whatever_chunk_is_damaged_the_rest_is_compared(tmp_path, every):
    record(tmp_path / "run", every)
    places = chunks(tmp_path / "run" / "run_0.mcap")
    assert len(places) > 8
    anew = 0
    for number, place in list(enumerate(places))[:: 3 if every == 7 else 8]:
        copy = damaged(tmp_path / "run", tmp_path / f"copy{number}", place)
        saved = recover(copy)
        for recording in (copy, saved.directory):
            result = verify(recording)
            assert result.difference is None, result.text
            assert re.search(r"^identical, \d+ steps, \S+ s$", result.text, re.M)
            assert 0 < result.steps <= STEPS
            if result.steps < STEPS and number < len(places) - 1:
                # What is not compared lies within what is said to be lost.
                assert (
                    sum(b - a for a, b in covered(result.text))
                    >= (STEPS - result.steps) * 0.002 - 1e-9
                )
            anew += "compared again from the snapshot" in result.text
        shutil.rmtree(copy)
        shutil.rmtree(saved.directory)
    assert (anew > 0) == (every == 7)


def test_nothing_is_excused_that_no_loss_explains(tmp_path, monkeypatch):
    """A wrong hash far behind a gap, with equal ones between."""
    record(tmp_path / "run", 10_000)
    places = chunks(tmp_path / "run" / "run_0.mcap")
    copy = damaged(tmp_path / "run", tmp_path / "copy", places[len(places) // 4])
    from rb_physics.recording import recorded_run

    read = recorded_run.Run._read

    def one_wrong(self):
        steps, hashes = read(self)
        hashes[-20] ^= 1
        return steps, hashes

    monkeypatch.setattr(recorded_run.Run, "_read", one_wrong)
    result = verify(copy)
    assert result.difference is not None
    assert result.difference.step == STEPS - 19


def test_a_body_that_came_in_what_is_lost(tmp_path):
    changes = {150: [("add_body", {"description": CRATE})],
               270: [("remove_body", {"body": "crate"})]}  # fmt: skip
    record(tmp_path / "run", 10_000, changes)
    bag = tmp_path / "run" / "run_0.mcap"
    place = next(p for p in reversed(chunks(bag)) if p.first_time <= 0.3e9 <= p.last_time)
    result = verify(damaged(tmp_path / "run", tmp_path / "copy", place))
    assert result.difference is None, result.text
    # The snapshots with the crate don't fit a world without it; that of 0.6 s does.
    assert re.search(r"lost from 0\.(2[89]\d*|3) to 0\.6\d* s: inputs are missing", result.text)
    assert 200 < result.steps < 250


def test_a_branch_behind_the_gap_begins_at_a_snapshot_there(tmp_path):
    record(tmp_path / "run", 7)
    places = chunks(tmp_path / "run" / "run_0.mcap")
    place = next(p for p in places if p.first_time > 0.25e9)
    copy = damaged(tmp_path / "run", tmp_path / "copy", place)
    assert branch(copy, tmp_path / "branch", 0.7, rerun="off") == 50
    assert verify(tmp_path / "branch").text.endswith("identical, 50 steps, 0.1 s")
    with pytest.raises(RecordingError, match="nothing to part from"):
        branch(copy, tmp_path / "other", 0.38, rerun="off")


def test_spans_are_merged_and_written():
    spans = [LostSpan(5, 9), LostSpan(1, 3), LostSpan(3, 6), LostSpan(20, None), LostSpan(12, 14)]
    assert merged(spans) == [LostSpan(1, 9), LostSpan(12, 14)]
    assert from_json(to_json(spans)) == spans
    for text in ("3", "[[1]]", "[[1, 2, 3]]", '[["a", 2]]', "[", '{"a": 1}'):
        with pytest.raises(ValueError):
            from_json(text)
