"""The bag: independent readers, limits, failures. No simulator needed."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time

import pytest
import yaml
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from rb_physics.recording.encoders import encode_clock, encode_string
from rb_physics.recording.errors import RecordingError
from rb_physics.recording.mcap_log import Attachment, McapLog
from rb_physics.recording.message_queue import Entry, MessageQueue
from rb_physics.recording.topics import Qos

LATCHED = Qos(durability="transient_local", depth=1)


def record(directory, steps: int = 100, **options) -> McapLog:
    attachments = [Attachment("scene.yaml", "application/yaml", b"bodies: []\n")]
    log = McapLog(directory, attachments=attachments, custom_data={"seed": "7"}, **options)
    clock = log.add_topic("/clock", "rosgraph_msgs/msg/Clock", Qos())
    names = log.add_topic("/sim_node/body_names", "std_msgs/msg/String", LATCHED)
    log.write([Entry(names, 0, 0, encode_string('["box"]'))])
    for step in range(1, steps + 1):
        time_ns = step * 1_000_000
        log.write([Entry(clock, time_ns, step, encode_clock(time_ns))])
    return log


def test_rosbags_reads_the_bag(tmp_path):
    anyreader = pytest.importorskip("rosbags.highlevel")
    log = record(tmp_path / "run")
    log.close()
    log.close()  # a second time does no harm
    assert log.error is None
    with anyreader.AnyReader([tmp_path / "run"]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == {
            "/clock": 100,
            "/sim_node/body_names": 1,
        }
        assert reader.duration == 100_000_001  # rosbags counts the end as exclusive
        stamps = [
            (reader.deserialize(raw, c.msgtype).clock.nanosec, time_ns)
            for c, time_ns, raw in reader.messages()
            if c.topic == "/clock"
        ]
    assert stamps == [(k * 1_000_000, k * 1_000_000) for k in range(1, 101)]


def test_mcap_ros2_support_decodes_it_and_attachments_are_there(tmp_path):
    decoder = pytest.importorskip("mcap_ros2.decoder")
    record(tmp_path / "run").close({"reason": "finished"})
    with open(tmp_path / "run" / "run_0.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        messages = list(reader.iter_decoded_messages(topics=["/clock"]))
        assert [m.sequence for _, _, m, _ in messages] == list(range(1, 101))
        assert messages[41][3].clock.nanosec == 42_000_000
        assert [a.name for a in reader.iter_attachments()] == ["scene.yaml"]
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
    assert metadata["rb_physics"] == {"seed": "7"}
    assert metadata["rb_physics_closing"] == {"reason": "finished", "dropped": "0"}


def test_rerun_checks_it(tmp_path):
    pytest.importorskip("rerun")
    record(tmp_path / "run").close()
    command = [sys.executable, "-m", "rerun", "mcap", "check", str(tmp_path / "run" / "run_0.mcap")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr


def test_metadata_is_complete_and_there_from_the_start(tmp_path):
    log = record(tmp_path / "run")
    early = yaml.safe_load((tmp_path / "run" / "metadata.yaml").read_text())
    assert early["rosbag2_bagfile_information"]["relative_file_paths"] == ["run_0.mcap"]
    log.close()
    information = yaml.safe_load((tmp_path / "run" / "metadata.yaml").read_text())[
        "rosbag2_bagfile_information"
    ]
    assert information["version"] == 9
    assert information["message_count"] == 101
    assert information["duration"] == {"nanoseconds": 100_000_000}
    topics = {
        t["topic_metadata"]["name"]: t["topic_metadata"]
        for t in information["topics_with_message_count"]
    }
    assert topics["/clock"]["type_description_hash"].startswith("RIHS01_")
    qos = topics["/sim_node/body_names"]["offered_qos_profiles"][0]
    assert qos["durability"] == "transient_local"
    assert not list((tmp_path / "run").glob("*.tmp"))


def test_split_files_are_each_complete(tmp_path):
    anyreader = pytest.importorskip("rosbags.highlevel")
    log = record(tmp_path / "run", split_duration=0.03)
    log.close()
    files = sorted((tmp_path / "run").glob("*.mcap"))
    assert len(files) == 4
    for path in files:
        with open(path, "rb") as file:
            assert [a.name for a in make_reader(file).iter_attachments()] == ["scene.yaml"]
    with anyreader.AnyReader([tmp_path / "run"]) as reader:
        times = [time_ns for _, time_ns, _ in reader.messages()]
    assert len(times) == 101
    assert times == sorted(times)


def test_a_large_scene_does_not_make_a_file_of_each_message(tmp_path):
    scene = Attachment("scene.yaml", "application/yaml", bytes(100_000))
    log = McapLog(tmp_path / "run", attachments=[scene], split_bytes=10_000, compression="none",
                 chunk_bytes=1000)  # fmt: skip
    topic = log.add_topic("/text", "std_msgs/msg/String", Qos())
    for step in range(2000):
        log.write([Entry(topic, step, step, encode_string("x" * 100))])
    log.close()
    assert log.error is None
    files = list((tmp_path / "run").glob("*.mcap"))
    # A message takes 140 to 200 bytes with its share of chunk and index; each file takes 100 kB of them.
    assert 2000 * 140 / 100_000 <= len(files) <= 2000 * 200 / 100_000 + 1


def test_existing_folder_is_refused(tmp_path):
    (tmp_path / "run").mkdir()
    with pytest.raises(RecordingError, match="exists already and is never overwritten"):
        McapLog(tmp_path / "run")
    assert list((tmp_path / "run").iterdir()) == []


def test_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(RecordingError, match=r"can't be made .*choose a folder you may write to"):
        McapLog(tmp_path / "file" / "run")


def test_vanished_folder_ends_in_a_sentence(tmp_path):
    log = record(tmp_path / "run")
    shutil.rmtree(tmp_path / "run")
    log.close()
    assert log.error is not None
    assert "recording stopped" in log.error
    assert log.counters["file_bytes"] == 0
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("option", [{"compression": "rar"}, {"policy": "hope"}])
def test_unknown_options_are_refused(tmp_path, option):
    with pytest.raises(ValueError, match="is not one of"):
        McapLog(tmp_path / "run", **option)


def test_unknown_message_type_is_refused(tmp_path):
    log = McapLog(tmp_path / "run")
    with pytest.raises(LookupError, match="no_such_msgs/msg/Thing"):
        log.add_topic("/x", "no_such_msgs/msg/Thing", Qos())
    log.close()


def test_drop_oldest_counts_and_spares_what_a_repetition_needs():
    queue = MessageQueue(1000, "drop_oldest")
    queue.essential.add(9)
    queue.put([Entry(9, 0, 0, b"x" * 100)])
    for step in range(50):
        queue.put([Entry(1, step, step, b"x" * 100)])
    kept = queue.take(0)
    assert kept[0].topic == 9
    assert [e.step for e in kept[1:]] == list(range(50 - len(kept) + 1, 50))
    assert queue.dropped == 51 - len(kept)
    assert queue.queued_bytes == 0


def test_block_waits_for_room_and_loses_nothing(tmp_path):
    log = record(tmp_path / "run", steps=3000, queue_bytes=500)
    log.close()
    assert log.messages == 3001
    assert log.counters["dropped"] == 0
    assert log.counters["blocked"] > 0


WRITER = textwrap.dedent(
    """
    import sys, time
    from rb_physics.recording.encoders import encode_clock
    from rb_physics.recording.mcap_log import McapLog
    from rb_physics.recording.message_queue import Entry
    from rb_physics.recording.topics import Qos
    log = McapLog(sys.argv[1])
    clock = log.add_topic("/clock", "rosgraph_msgs/msg/Clock", Qos())
    start = time.monotonic_ns()
    step = 0
    while True:
        step += 1
        now = time.monotonic_ns() - start
        log.write([Entry(clock, now, step, encode_clock(now))])
        print(now, flush=True)
        time.sleep(0.001)
    """
)


def read_unfinished(path) -> list[int]:
    times = []
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Message):
                    times.append(record.log_time)
        except EndOfFile:  # the torn end, if there is one
            pass
    return times


def test_sigkill_loses_at_most_100_ms(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(tmp_path / "run")], stdout=subprocess.PIPE, text=True
    )
    last_seen = 0
    while last_seen < 500_000_000:
        last_seen = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    last_seen = max([last_seen, *map(int, process.communicate(timeout=10)[0].split())])
    times = read_unfinished(tmp_path / "run" / "run_0.mcap")
    assert last_seen - times[-1] <= 100_000_000
    assert times == sorted(times)


SLOW = textwrap.dedent(
    """
    import os, random, sys, time
    from rb_physics.recording import mcap_log
    from rb_physics.recording.encoders import encode_string
    from rb_physics.recording.message_queue import Entry
    from rb_physics.recording.topics import Qos

    write = os.write
    def slow(descriptor, data):
        time.sleep(len(data) / 2e6)  # a disk of 2 MB/s
        return write(descriptor, data)
    os.write = slow

    log = mcap_log.McapLog(sys.argv[1], policy="drop_oldest", chunk_bytes=32_000, compression="none")
    output = log.add_topic("/output", "std_msgs/msg/String", Qos())
    needed = log.add_topic("/needed", "std_msgs/msg/String", Qos(), essential=True)
    data = encode_string("x" * 5000)  # 5 MB/s
    start, step = time.monotonic(), 0
    while True:
        step += 1
        log.write([Entry(output, step, step, data), Entry(needed, step, step, encode_string("y"))])
        print(step, log.counters["dropped"], flush=True)
        time.sleep(max(0.0, start + step * 1e-3 - time.monotonic()))
    """
)


def test_on_a_slow_disk_drop_oldest_keeps_up_with_what_a_repetition_needs(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, str(tmp_path / "run")], stdout=subprocess.PIPE, text=True
    )
    last = (0, 0)
    while last[0] < 1500:
        last = tuple(map(int, process.stdout.readline().split()))
    os.kill(process.pid, signal.SIGKILL)
    for line in process.communicate(timeout=10)[0].splitlines():
        last = tuple(map(int, line.split())) if len(line.split()) == 2 else last
    steps = {"/needed": [], "/output": []}
    with open(tmp_path / "run" / "run_0.mcap", "rb") as file, contextlib.suppress(EndOfFile):
        names = {}
        for record in StreamReader(file).records:
            if isinstance(record, Channel):
                names[record.id] = record.topic
            elif isinstance(record, Message):
                steps[names[record.channel_id]].append(record.sequence)
    assert steps["/needed"] == list(range(1, len(steps["/needed"]) + 1))  # not one is missing
    # Steps of 1 ms. All of it would come 0.9 s late; a third of that allows for a busy machine.
    assert last[0] - steps["/needed"][-1] <= 300
    assert last[1] > 100  # dropped and counted
    assert 100 < len(steps["/output"]) <= last[0] - last[1]  # and as much written as goes


FULL = textwrap.dedent(
    """
    import resource, sys, time
    from rb_physics.recording.mcap_log import McapLog
    from rb_physics.recording.message_queue import Entry
    from rb_physics.recording.topics import Qos
    log = McapLog(sys.argv[1], compression="none")
    topic = log.add_topic("/s", "std_msgs/msg/String", Qos())
    if len(sys.argv) > 2:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
    step = 0
    while log.error is None and step < 5000:
        step += 1
        log.write([Entry(topic, step * 1000000, step, b"\\0\\1\\0\\0" + bytes(4) + bytes(20000))])
        time.sleep(0.0005)
    log.close()
    print(log.error)
    """
)


def run_until_full(directory, *arguments) -> str:
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(directory), *arguments],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_write_error_leaves_complete_chunks(tmp_path):
    error = run_until_full(tmp_path / "run", "3000000")
    assert "recording stopped" in error
    assert "rb_physics recover" in error
    size = (tmp_path / "run" / "run_0.mcap").stat().st_size
    assert 2_000_000 < size <= 3_000_000
    times = read_unfinished(tmp_path / "run" / "run_0.mcap")
    assert len(times) > 90
    assert times == [1_000_000 * (k + 1) for k in range(len(times))]


def test_full_disk_ends_in_a_finished_file(tmp_path):
    mount = tmp_path / "small"
    mount.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=6m", "tmpfs", str(mount)]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("a small file system can only be mounted by root")
    try:
        error = run_until_full(mount / "run")
        assert "is full" in error
        assert "kept and readable" in error
        with open(mount / "run" / "run_0.mcap", "rb") as file:
            messages = list(make_reader(file).iter_messages())
        assert len(messages) > 200
        information = yaml.safe_load((mount / "run" / "metadata.yaml").read_text())
        assert information["rosbag2_bagfile_information"]["message_count"] == len(messages)
    finally:
        subprocess.run(["umount", str(mount)], check=True)


def test_writing_does_not_hold_the_caller(tmp_path):
    log = McapLog(tmp_path / "run")
    topic = log.add_topic("/s", "std_msgs/msg/String", Qos())
    data = encode_string("x" * 5000)
    slowest = 0.0
    for step in range(300):
        start = time.perf_counter()
        log.write([Entry(topic, step, step, data)])
        slowest = max(slowest, time.perf_counter() - start)
        time.sleep(0.001)
    log.close()
    # Queueing is a list append: microseconds, unless the scheduler or the interpreter's switch
    # interval (5 ms) comes between; 50 ms is ten of those.
    assert slowest < 0.05
