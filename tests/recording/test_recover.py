"""recover: whole bags from torn and damaged ones."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from mcap.reader import make_reader

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.recover import recover
from rb_physics.recording.replay import verify
from rb_physics.recording.summary import summary

SCENE = """
dt: 0.001
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: box, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0, 0, 0.1]}
  - {name: ball, shape: {type: sphere, radius: 0.05}, mass: 0.5, position: [1, 0, 0.3], restitution: 0.5}
"""


def record(directory, steps: int = 200, **options) -> None:
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, directory, scene=scene, **options) as recorder:
        for _ in range(steps):
            world.step()
            recorder.after_step()


def torn(tmp_path, size: int):
    """A copy of a recording whose file ends after `size` bytes."""
    target = tmp_path / "torn"
    shutil.rmtree(target, ignore_errors=True)
    shutil.rmtree(tmp_path / "torn_recovered", ignore_errors=True)
    shutil.copytree(tmp_path / "run", target)
    path = target / "torn_0.mcap"
    os.rename(target / "run_0.mcap", path)
    metadata = target / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("run_0.mcap", "torn_0.mcap"))
    os.truncate(path, size)
    return target


def test_a_whole_recording_is_copied_whole(tmp_path):
    record(tmp_path / "run")
    before = {p.name: p.read_bytes() for p in (tmp_path / "run").iterdir()}
    result = recover(tmp_path / "run")
    assert result.directory == tmp_path / "run_recovered"
    assert (result.torn_bytes, result.damaged_chunks, result.until) == (0, 0, 0.2)
    assert {p.name: p.read_bytes() for p in (tmp_path / "run").iterdir()} == before
    assert list(Recording(result.directory).messages()) == list(
        Recording(tmp_path / "run").messages()
    )
    anyreader = pytest.importorskip("rosbags.highlevel")
    with anyreader.AnyReader([result.directory]) as reader:
        assert reader.message_count == result.messages
    assert verify(result.directory).text.endswith("identical, 200 steps, 0.2 s")
    with pytest.raises(RecordingError, match="never overwritten"):
        recover(tmp_path / "run")


def test_torn_anywhere_it_recovers_or_says_why(tmp_path):
    record(tmp_path / "run", steps=40)
    size = (tmp_path / "run" / "run_0.mcap").stat().st_size
    last = 0
    for length in [0, 1, 7, 8, 9, 30, *range(100, size, max(1, size // 25)), size - 1]:
        copy = torn(tmp_path, length)
        try:
            result = recover(copy)
        except RecordingError as error:
            assert "holds no whole message" in str(error)
            assert not (tmp_path / "torn_recovered").exists()
            assert last == 0
            continue
        assert result.messages >= last
        last = result.messages
        found = list(Recording(result.directory).messages())
        assert len(found) == result.messages
    assert last == len(list(Recording(tmp_path / "run").messages()))


def test_a_damaged_chunk_is_left_out_and_counted(tmp_path):
    record(tmp_path / "run", chunk_bytes=2000)
    path = tmp_path / "run" / "run_0.mcap"
    content = bytearray(path.read_bytes())
    with open(path, "rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    middle = chunks[len(chunks) // 2]
    content[middle.chunk_start_offset + middle.chunk_length - middle.compressed_size // 2] ^= 0x10
    path.write_bytes(content)
    with pytest.raises(RecordingError, match="a chunk of .*rb_physics recover"):
        list(Recording(tmp_path / "run").messages())
    result = recover(tmp_path / "run")
    assert result.damaged_chunks == 1
    assert result.messages > 100


def test_decompression_bombs_are_bounded(tmp_path):
    zstandard = pytest.importorskip("zstandard")
    from mcap.records import Chunk

    from rb_physics.recording.mcap_reader import decompressed

    bomb = zstandard.compress(bytes(50_000_000))
    assert len(bomb) < 10_000
    chunk = Chunk("zstd", bomb, 0, 0, 0, 1000)
    with pytest.raises(ValueError, match="it holds 1001 bytes instead of 1000"):
        decompressed(chunk)
    with pytest.raises(ValueError, match="claims"):
        decompressed(Chunk("zstd", bomb, 0, 0, 0, 2**40))


def test_folders_that_are_no_recordings_say_so(tmp_path):
    (tmp_path / "zero").mkdir()
    (tmp_path / "zero" / "zero_0.mcap").write_bytes(b"")
    with pytest.raises(RecordingError, match="holds no whole message"):
        recover(tmp_path / "zero")
    with pytest.raises(RecordingError, match="holds no messages"):
        summary(tmp_path / "zero")
    with pytest.raises(RecordingError, match="empty or damaged at its start"):
        verify(tmp_path / "zero")
    with pytest.raises(RecordingError, match="does not exist"):
        recover(tmp_path / "none")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError, match=r"holds no .mcap file"):
        recover(tmp_path / "empty")
    assert not (tmp_path / "empty_recovered").exists()


WRITER = textwrap.dedent(
    """
    import sys, time
    import rb_physics as rb
    from rb_physics.recording import Recorder
    scene = rb.Scene.from_yaml(sys.argv[2])
    world = scene.build()
    recorder = Recorder(world, sys.argv[1], scene=scene)
    start = time.monotonic()
    while True:
        world.step()
        recorder.after_step()
        print(world.step_count, flush=True)
        time.sleep(max(0.0, start + world.time - time.monotonic()))
    """
)


def kill_and_recover(directory, until_step: int, scene: str = SCENE) -> None:
    """Kills a real-time 1 kHz run at a step, recovers and verifies it."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(directory), scene], stdout=subprocess.PIPE, text=True
    )
    seen = 0
    while seen < until_step:
        seen = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    seen = max([seen, *map(int, process.communicate(timeout=10)[0].split())])
    assert "torn off" in summary(directory)
    result = recover(directory)
    # The promise: what was simulated more than 100 ms before the kill is there.
    assert result.until >= seen * 1e-3 - 0.1
    verification = verify(result.directory)
    assert verification.difference is None, verification.text
    assert verification.steps >= seen - 100


def test_killed_run_recovers_and_verifies(tmp_path):
    kill_and_recover(tmp_path / "run", 700)


@pytest.mark.soak
@pytest.mark.parametrize("attempt", range(100))
def test_killed_at_any_moment(tmp_path, attempt):
    scene = rb.load_scene("hundred_bodies").to_yaml()
    kill_and_recover(tmp_path / "run", 200 + (attempt * 7919) % 1500, scene)


def damage(directory, seed: int) -> None:
    """Overwrites a few bytes of a recording's file, anywhere or near its start."""
    rng = np.random.default_rng(seed)
    [path] = directory.glob("*.mcap")
    content = bytearray(path.read_bytes())
    for _ in range(rng.choice([1, 1, 3, 20])):
        end = len(content) if rng.random() < 0.6 else min(4000, len(content))
        content[rng.integers(end)] = rng.integers(256)
    path.write_bytes(content)


def survive(tmp_path, seeds) -> None:
    """Whatever the bytes, every reader answers or says what is wrong in one sentence."""
    record(tmp_path / "run", steps=30)
    for seed in seeds:
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.rmtree(tmp_path / "copy_recovered", ignore_errors=True)
        shutil.copytree(tmp_path / "run", copy)
        os.rename(copy / "run_0.mcap", copy / "copy_0.mcap")
        metadata = copy / "metadata.yaml"
        metadata.write_text(metadata.read_text().replace("run_0.mcap", "copy_0.mcap"))
        damage(copy, seed)
        for read in (summary, recover, verify):
            try:
                read(copy)
            except (RecordingError, rb.SceneError, rb.DivergedError) as error:
                assert "\n" not in str(error)


def test_damaged_bytes_never_break_a_reader(tmp_path):
    survive(tmp_path, range(20))


@pytest.mark.soak
def test_damaged_bytes_never_break_a_reader_at_length(tmp_path):
    survive(tmp_path, range(20, 1000))


def test_a_flipped_bit_of_an_attachment_is_found_and_named(tmp_path):
    record(tmp_path / "run")
    whole = (tmp_path / "run" / "run_0.mcap").read_bytes()
    for name, word in (("scene.yaml", b"restitution"), ("topics.json", b"direction")):
        data = bytearray(whole)
        data[data.index(word)] ^= 1
        (tmp_path / "run" / "run_0.mcap").write_bytes(data)
        log = Recording(tmp_path / "run")
        with pytest.raises(RecordingError, match=f"attachment {name} of .*run_0.mcap is damaged"):
            log.attachment(name, "")
        assert f"attachment {name}: its checksum is wrong" in summary(tmp_path / "run")
        saved = recover(tmp_path / "run")
        assert saved.damaged_attachments == (name,)
        with pytest.raises(RecordingError, match=f"no {name}: it was damaged when the recording"):
            Recording(saved.directory).attachment(name, "")
        assert f"lost when recovered: {name}" in summary(saved.directory)
        if name == "scene.yaml":
            with pytest.raises(RecordingError, match="attachment scene.yaml of"):
                verify(tmp_path / "run")
            with pytest.raises(RecordingError, match="holds no scene.yaml: it was damaged"):
                verify(saved.directory)
        shutil.rmtree(saved.directory)
