"""The MCAP writer: what the mcap package reads back, with every index used."""

from __future__ import annotations

import io
import os

import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from rb_physics.recording import mcap_log
from rb_physics.recording.encoders import encode_string
from rb_physics.recording.mcap_log import McapLog
from rb_physics.recording.mcap_writer import COMPRESSIONS, McapWriter
from rb_physics.recording.message_queue import Entry
from rb_physics.recording.topics import Qos


def write(compression: str, messages: list[tuple[int, int, bytes]]) -> io.BytesIO:
    """A file of (channel index, time, data), in small chunks."""
    output = io.BytesIO()
    writer = McapWriter(output, compression, chunk_bytes=500)
    writer.start("ros2", "test")
    writer.add_attachment("a.txt", "text/plain", b"hello", 3, 4)
    schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data")
    channels = [writer.add_channel(f"/c{i}", "cdr", schema, {"k": "v"}) for i in range(3)]
    for sequence, (channel, time_ns, data) in enumerate(messages):
        writer.add_message(channels[channel], time_ns, data, time_ns + 1, sequence)
    writer.add_metadata("notes", {"x": "ü"})
    writer.finish()
    output.seek(0)
    return output


MESSAGES = [(k % 3, 10 * k, bytes([k % 251]) * (k % 60)) for k in range(200)]


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_the_mcap_package_reads_it_back(compression):
    file = write(compression, MESSAGES)
    reader = make_reader(file, validate_crcs=True)
    summary = reader.get_summary()
    assert summary.statistics.message_count == 200
    assert summary.statistics.channel_message_counts == {1: 67, 2: 67, 3: 66}
    assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 1990)
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 5
    found = [
        (int(c.topic[2:]), m.log_time, m.data, m.publish_time, m.sequence)
        for _, c, m in reader.iter_messages()
    ]
    assert found == [(c, t, d, t + 1, k) for k, (c, t, d) in enumerate(MESSAGES)]
    late = [m.log_time for _, _, m in reader.iter_messages(topics=["/c1"], starting_at=1500)]
    assert late == [t for c, t, _ in MESSAGES if c == 1 and t >= 1500]
    [attachment] = reader.iter_attachments()
    assert (attachment.data, attachment.create_time, attachment.log_time) == (b"hello", 3, 4)
    assert [m.metadata for m in reader.iter_metadata()] == [{"x": "ü"}]
    file.seek(0)
    assert len(list(StreamReader(file, validate_crcs=True).records)) > 200


def test_message_indexes_point_at_the_messages():
    file = write("none", MESSAGES)
    content = file.getvalue()
    summary = make_reader(file).get_summary()
    for chunk in summary.chunk_indexes:
        # An uncompressed chunk's messages begin behind its head: 9 + 28 + 4 + 0 + 8 bytes.
        records = content[chunk.chunk_start_offset + 49 :]
        for channel, offset in chunk.message_index_offsets.items():
            assert content[offset] == 0x07
            assert int.from_bytes(content[offset + 9 : offset + 11], "little") == channel
            size = int.from_bytes(content[offset + 11 : offset + 15], "little")
            for entry in range(0, size, 16):
                at = int.from_bytes(content[offset + 23 + entry : offset + 31 + entry], "little")
                assert records[at] == 0x05
                assert int.from_bytes(records[at + 9 : at + 11], "little") == channel


def test_an_empty_file_is_whole():
    reader = make_reader(write("zstd", []), validate_crcs=True)
    assert reader.get_summary().statistics.message_count == 0
    assert len(reader.get_summary().channels) == 3


def test_the_index_in_memory_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(mcap_log, "_INDEX_BYTES", 3000)
    log = McapLog(tmp_path / "run", chunk_bytes=200)
    topic = log.add_topic("/s", "std_msgs/msg/String", Qos())
    for step in range(500):
        log.write([Entry(topic, step, step, encode_string("x" * 200))])
    log.close()
    files = sorted(tmp_path.glob("run/*.mcap"), key=os.path.getmtime)
    assert len(files) > 5
    count = 0
    for path in files:
        with open(path, "rb") as file:
            count += make_reader(file).get_summary().statistics.message_count
    assert count == 500
