"""Reading parts of a recording: by topic, from a moment, what was latched before it."""

from __future__ import annotations

import os

import pytest

from rb_physics.recording.encoders import encode_string
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.mcap_log import McapLog
from rb_physics.recording.message_queue import Entry
from rb_physics.recording.topics import Qos


@pytest.fixture(params=["whole", "torn", "several files"])
def recording(request, tmp_path):
    """Topic /often every 10 ns up to 10 000, /rare at 0, 3000, 6000, 9000 beside it."""
    options = {"split_duration": 2e-6} if request.param == "several files" else {}
    log = McapLog(tmp_path / "run", chunk_bytes=400, **options)
    often = log.add_topic("/often", "std_msgs/msg/String", Qos())
    rare = log.add_topic("/rare", "std_msgs/msg/String", Qos())
    for k in range(1001):
        entries = [Entry(often, 10 * k, k, encode_string(str(k)))]
        if k % 300 == 0:
            entries.append(Entry(rare, 10 * k, k, encode_string(f"rare {k}")))
        log.write(entries)
    log.close()
    if request.param == "torn":
        [path] = (tmp_path / "run").glob("*.mcap")
        os.truncate(path, path.stat().st_size - 20)
    return Recording(tmp_path / "run")


def test_topics_and_start(recording):
    everything = list(recording.messages())
    assert len(everything) == 1005
    for topics in (None, {"/rare"}, {"/often"}, {"/rare", "/often"}, {"/none"}, set()):
        for start in (0, 1, 2995, 3000, 3001, 9999, 10_000, 10_001):
            wanted = [
                m
                for m in everything
                if m.log_time >= start and (topics is None or m.topic in topics)
            ]
            assert list(recording.messages(topics, start)) == wanted


def test_span(recording):
    last = [message.log_time for message in recording.messages()][-1]  # the torn one ends earlier
    assert recording.span() == (0, last)


def test_latest(recording):
    everything = list(recording.messages())
    for before in (0, 1, 3000, 3001, 9500, 20_000):
        last = {m.topic: m for m in everything if m.log_time < before}
        found = recording.latest({"/rare", "/often", "/none"}, before)
        assert {m.topic: m for m in found} == last
        assert [m.log_time for m in found] == sorted(m.log_time for m in found)
