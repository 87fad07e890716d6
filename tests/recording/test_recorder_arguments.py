"""A recorder refuses what it can't use before it makes a folder, in one sentence."""

import math

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError, TopicError, load_topics

BAD = [
    ({"world": 3}, "world is 3; it must be an rb.World"),
    ({"directory": 3}, "directory is 3; it must be the path of a new folder"),
    ({"scene": "demo"}, "scene is 'demo'; it must be the rb.Scene"),
    (
        {"topics": "topics.yaml"},
        "topics is 'topics.yaml'; it must be what load_topics(path) returns",
    ),
    ({"node_name": ""}, "node_name is ''; it must be the name of a node"),
    ({"node_name": None}, "node_name is None"),
    ({"rerun": "fil"}, "rerun is 'fil'; it must be off, file or live"),
    ({"rerun": True}, "rerun is True; it must be off, file or live"),
    (
        {"snapshot_interval": math.nan},
        "snapshot_interval is nan; it must be a finite number > 0 (s)",
    ),
    ({"snapshot_interval": 0}, "> 0 (s)"),
    ({"custom_data": {"a": 1}}, "custom_data is {'a': 1}; it must be a dict of texts"),
    ({"compresion": "zstd"}, "unknown option 'compresion'; did you mean 'compression'?"),
    ({"compression": "gzip"}, "'zstd', 'lz4' or 'none'"),
    ({"policy": 1}, "'block' or 'drop_oldest'"),
    ({"split_bytes": -1}, "split_bytes is -1; it must be a whole number ≥ 10000"),
    ({"split_bytes": 9_999}, "split_bytes is 9999; it must be a whole number ≥ 10000"),
    ({"split_duration": "1"}, "split_duration is '1'; it must be a finite number > 0 (s)"),
    ({"queue_bytes": 0.5}, "queue_bytes is 0.5; it must be a whole number"),
    ({"flush_interval": math.inf}, "flush_interval is inf"),
    ({"chunk_bytes": None}, "chunk_bytes is None"),
    ({"fsync": 1}, "fsync is 1; it must be True or False"),
    ({"initial": "state"}, "initial is 'state'; it must be what world.save() returned, or None"),
    ({"first": ["reset"]}, "it must be a list of pairs (name of an operation"),
    ({"first": 3}, "first is 3; it must be a list of pairs"),
    ({"log_start": -1}, "log_start is -1; it must be a whole number ≥ 0"),
    ({"log_start": 1.5}, "log_start is 1.5; it must be a whole number"),
    ({"held_wrenches": {}}, "held_wrenches is {}; it must be what HeldWrenches.to_json returns"),
]


@pytest.mark.parametrize(("bad", "words"), BAD, ids=lambda v: str(v)[:40])
def test_bad_arguments(tmp_path, bad, words):
    given = {"world": rb.World(), "directory": tmp_path / "run", **bad}
    with pytest.raises(RecordingError) as caught:
        Recorder(given.pop("world"), given.pop("directory"), **given)
    assert words in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", [3, b"topics.yaml", ["topics.yaml"]])
def test_what_is_no_path_of_a_topics_file(path):
    with pytest.raises(TopicError, match="path is .*; it must be the path of a topics file"):
        load_topics(path)
