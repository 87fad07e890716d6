"""Whatever is in a bag, every command answers in one sentence: no traceback, no hang, bounded memory,
nothing written elsewhere."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import rb_physics as rb
from rb_physics.cli import main
from rb_physics.recording import Recorder, encoders, load_topics
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.mcap_log import Attachment, McapLog
from rb_physics.recording.mcap_writer import McapWriter
from rb_physics.recording.message_queue import Entry
from rb_physics.recording.topics import Qos

SCENE = """
dt: 0.002
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: box, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0, 0, 0.1]}
"""


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A recording of 30 steps with a wrench."""
    directory = tmp_path_factory.mktemp("good") / "run"
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, directory, scene=scene, snapshot_interval=0.02) as recorder:
        recorder.perform("apply_wrench", body="box", force=(1, 0, 0))
        for _ in range(30):
            world.step()
            recorder.after_step()
    return directory


def commands(bag: Path, folder: Path) -> list[list[str]]:
    """Every command that reads a recording; `view` takes a viewer, see `test_messages`."""
    out = str(folder / "out")
    return [
        ["info", str(bag)],
        ["verify", str(bag)],
        ["verify", str(bag), "--start", "0.03"],
        ["recover", str(bag)],
        ["replay", str(bag), "--from", "0.02", "--record", out, "--no-rerun"],
        ["compare", str(bag), str(bag)],
        ["export", str(bag), out + "_csv"],
        ["plot", str(bag), out + ".png"],
    ]


def answers(bag: Path, folder: Path) -> dict[str, int]:
    """Exit codes by command; fails when one breaks, says nothing, or writes elsewhere."""
    folder.mkdir(exist_ok=True)
    before = contents(bag)
    codes = {}
    for arguments in commands(bag, folder):
        result = CliRunner().invoke(main, arguments)
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            pytest.fail(f"{arguments[0]}: {result.exception!r}")
        if result.exit_code != 0:
            said = [line for line in result.output.splitlines() if line.startswith("Error: ")]
            assert len(said) == 1 or arguments[0] in ("verify", "compare"), result.output
            assert "Traceback" not in result.output
        codes[arguments[0]] = result.exit_code
    assert contents(bag) == before
    allowed = {bag.name, bag.name + "_recovered", folder.name}
    assert {p.name for p in bag.parent.iterdir()} <= allowed
    return codes


def contents(bag: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in bag.iterdir() if p.is_file()}


def changed(good: Path, target: Path, *, notes=None, attachments=None, messages=None) -> Path:
    """A copy of the good bag with other notes, attachments (None: left out) or message bytes."""
    log = Recording(good)
    noted = {k: v for k, v in (log.custom_data | (notes or {})).items() if v is not None}
    kept = log.attachments() | (attachments or {})
    copy = McapLog(
        target,
        custom_data=noted,
        attachments=[Attachment(n, "", d) for n, d in kept.items() if d is not None],
    )
    ids: dict[str, int] = {}
    for m in log.messages():
        if m.topic not in ids:
            ids[m.topic] = copy.add_topic(m.topic, m.type, Qos())
        data = (messages or {}).get(m.topic, m.data)
        copy.write([Entry(ids[m.topic], m.log_time, m.step, data)])
    copy.close()
    return target


LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 9)}]\n" for k in range(12)
)
DEEP = "[" * 30_000 + "]" * 30_000
SCENES = {
    "laughs": LAUGHS + "bodies: *m\n",
    "deep": "bodies: " + DEEP,
    "python": "!!python/object/apply:os.system ['touch /tmp/owned']\n",
    "not text": "\xff\xfe\x00",
    "empty": "",
    "a number": "7",
    "other bodies": SCENE.replace("box", "crate"),
    "fewer bodies": "bodies: []\n",
    "mesh elsewhere": """
bodies:
  - {name: box, mass: 1, shape: {type: triangle_mesh, file: /etc/passwd}}
""",
    "huge number": SCENE.replace("mass: 2.0", "mass: 1e400"),
    "huge hull": SCENE.replace("mass: 2.0", "mass: 2.0, foo: 3"),
}


@pytest.mark.parametrize("name", SCENES)
def test_scenes(good, tmp_path, name):
    bag = changed(good, tmp_path / "bag", attachments={"scene.yaml": SCENES[name].encode()})
    codes = answers(bag, tmp_path / "folder")
    assert codes["verify"] != 0
    assert codes["replay"] != 0
    assert codes["info"] == 0
    assert not Path("/tmp/owned").exists()


NOTES = {
    "version of tomorrow": {"format_version": "99"},
    "version of words": {"format_version": "two"},
    "no version": {"format_version": None},
    "version zero": {"format_version": "0"},
    "settings": {"settings": "{"},
    "settings of others": {"settings": '{"gravity": "down"}'},
    "settings missing": {"settings": None},
    "settings list": {"settings": "[1, 2]"},
    "settings unknown": {"settings": '{"gravity": [0, 0, -9.81], "colour": "red"}'},
    "dt": {"dt": "soon"},
    "dt zero": {"dt": "0"},
    "dt nan": {"dt": "nan"},
    "dt missing": {"dt": None},
    "step": {"first_step": "-"},
    "step huge": {"first_step": "9" * 30},
    "node": {"node_name": None},
    "node path": {"node_name": "../../x"},
    "scene name": {"scene": "../../../etc/passwd"},
}


@pytest.mark.parametrize("name", NOTES)
def test_notes(good, tmp_path, name):
    answers(changed(good, tmp_path / "bag", notes=NOTES[name]), tmp_path / "folder")


ATTACHMENTS = {
    "no topics": {"topics.json": None},
    "topics text": {"topics.json": b"hello"},
    "topics number": {"topics.json": b"7"},
    "topics rows": {"topics.json": b'[{"name": 3}]'},
    "topics deep": {"topics.json": DEEP.encode()},
    "no scene": {"scene.yaml": None},
    "nothing": {"scene.yaml": None, "topics.json": None},
    "path in a name": {"../../evil.txt": b"x"},
    "initial": {"initial.snapshot": b"not a snapshot"},
}


@pytest.mark.parametrize("name", ATTACHMENTS)
def test_attachments(good, tmp_path, name):
    answers(changed(good, tmp_path / "bag", attachments=ATTACHMENTS[name]), tmp_path / "folder")


BODIES = encoders.encode_string(json.dumps({"format_version": 1, "bodies": [{"name": 1}]}))
MESSAGES = {
    "empty": b"",
    "short": b"\0\1\0\0",
    "big endian": b"\0\0\0\0" + bytes(40),
    "lengths": b"\0\1\0\0" + b"\xff" * 60,
    "bodies": BODIES,
    "deep json": encoders.encode_string(DEEP),
    "operation": encoders.encode_string('{"step": 0, "name": "launch", "arguments": {}}'),
    "operation of one": encoders.encode_string(
        '{"step": 0, "name": "move", "arguments": {"x": 1}}'
    ),
    "operation restore": encoders.encode_string(
        '{"step": 0, "name": "restore", "arguments": {"snapshot": "AAAA"}}'
    ),
    "operation step": encoders.encode_string('{"step": 1e99, "name": "reset", "arguments": {}}'),
    "operation list": encoders.encode_string("[1]"),
}


@pytest.mark.parametrize("name", MESSAGES)
@pytest.mark.parametrize(
    "topic",
    [
        "operations",
        "state_hash",
        *(
            pytest.param(topic, marks=pytest.mark.soak)
            for topic in ("bodies", "snapshots", "poses", "contacts", "totals", "events")
        ),
    ],
)
def test_messages(good, tmp_path, topic, name):
    full = "/sim_node/" + topic
    bag = changed(good, tmp_path / "bag", messages={full: MESSAGES[name]})
    answers(bag, tmp_path / "folder")
    rerun = pytest.importorskip("rerun")
    assert rerun
    from rb_physics.recording import RecordingError
    from rb_physics.recording.render import write_rrd

    try:
        write_rrd(bag, tmp_path / "folder" / "view.rrd")
    except RecordingError as error:
        assert "\n" not in str(error)


METADATA = {
    "laughs": LAUGHS + "rosbag2_bagfile_information: {custom_data: {x: *m}}\n",
    "deep": DEEP,
    "deep inside": "rosbag2_bagfile_information: {custom_data: {x: " + DEEP + "}}",
    "self": "rosbag2_bagfile_information: &a {custom_data: {x: *a}}",
    "null": "\0\0\0",
    "tag": "!!python/object/apply:os.system ['touch /tmp/owned']",
    "path": "rosbag2_bagfile_information: {relative_file_paths: ['../../../etc/passwd.mcap']}",
    "absolute": "rosbag2_bagfile_information: {relative_file_paths: ['/etc/x.mcap']}",
    "missing": "rosbag2_bagfile_information: {relative_file_paths: ['other.mcap']}",
    "empty": "",
    "date": "rosbag2_bagfile_information: {relative_file_paths: [2001-01-01]}",
}


@pytest.mark.parametrize("name", METADATA)
def test_metadata(good, tmp_path, name):
    bag = tmp_path / "bag"
    shutil.copytree(good, bag)
    os.rename(bag / "run_0.mcap", bag / "bag_0.mcap")
    (bag / "metadata.yaml").write_text(METADATA[name])
    answers(bag, tmp_path / "folder")
    assert not Path("/tmp/owned").exists()


def test_a_link_to_another_place_is_not_followed_out(good, tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "secret.mcap").write_bytes(b"not for you")
    os.symlink(tmp_path / "folder" / "secret.mcap", bag / "bag_0.mcap")
    assert answers(bag, tmp_path / "folder")["verify"] != 0


def test_folders_and_devices_named_like_bags(tmp_path):
    bag = tmp_path / "bag"
    (bag / "bag_0.mcap").mkdir(parents=True)
    assert set(answers(bag, tmp_path / "folder").values()) == {1}
    (bag / "bag_0.mcap").rmdir()
    os.mkfifo(bag / "bag_0.mcap")  # opening it to read would wait for ever
    for arguments in commands(bag, tmp_path / "folder")[:4]:
        assert CliRunner().invoke(main, arguments).exit_code == 1


def test_foreign_bags(tmp_path):
    for name, profile in (("ros1", "ros1"), ("plain", "")):
        bag = tmp_path / name / "bag"
        bag.mkdir(parents=True)
        with open(bag / "bag_0.mcap", "wb") as file:
            writer = McapWriter(file)
            writer.start(profile, "somebody")
            schema = writer.add_schema("foo/Bar", "protobuf", b"\0\1")
            channel = writer.add_channel("/foo", "protobuf", schema, {})
            for k in range(10):
                writer.add_message(channel, k, b"x" * k, k, k)
            writer.finish()
        codes = answers(bag, bag.parent / "folder")
        assert codes["verify"] == codes["replay"] == codes["export"] == 1
        assert codes["info"] == 0


BOMB = """
import resource, sys
limit = 1_500_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
from rb_physics.cli import main
main()
"""


@pytest.mark.parametrize("claims", ["the truth", "little", "far too much"])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_decompression_bombs(tmp_path, compression, claims):
    """2 GB of zeros in a chunk of some KB (lz4: MB): refused in 1.5 GB of address space."""
    if compression == "zstd":
        zstandard = pytest.importorskip("zstandard")
        packer = zstandard.ZstdCompressor().compressobj()
        zeros = bytes(1 << 20)
        packed = b"".join(packer.compress(zeros) for _ in range(2048)) + packer.flush()
    else:
        frame = pytest.importorskip("lz4.frame")
        packer = frame.LZ4FrameCompressor()
        zeros = bytes(1 << 20)
        packed = packer.begin() + b"".join(packer.compress(zeros) for _ in range(2048))
        packed += packer.flush()
    size = {"the truth": 2 << 30, "little": 1000, "far too much": 1 << 60}[claims]
    bag = tmp_path / "bag"
    bag.mkdir()
    body = struct.pack("<QQQI", 0, 0, size, 0) + struct.pack("<I", len(compression))
    body += compression.encode() + struct.pack("<Q", len(packed)) + packed
    record = struct.pack("<BQ", 6, len(body)) + body
    header = struct.pack("<BQ", 1, 8) + bytes(8)
    (bag / "bag_0.mcap").write_bytes(b"\x89MCAP0\r\n" + header + record)
    for command in ("info", "verify", "recover"):
        done = subprocess.run(
            [sys.executable, "-c", BOMB, command, str(bag)],
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        assert done.returncode == 1
        assert done.stderr.startswith("Error: ")
        assert "Traceback" not in done.stderr
        assert "MemoryError" not in done.stderr


def truncated(good: Path, tmp_path: Path, sizes) -> None:
    path = good / "run_0.mcap"
    content = path.read_bytes()
    bag = tmp_path / "bag"
    shutil.copytree(good, bag)
    (bag / "run_0.mcap").unlink()
    (bag / "metadata.yaml").unlink()
    for size in sizes:
        (bag / "bag_0.mcap").write_bytes(content[:size])
        shutil.rmtree(tmp_path / "bag_recovered", ignore_errors=True)
        for arguments in (["info", str(bag)], ["recover", str(bag)], ["verify", str(bag)]):
            result = CliRunner().invoke(main, arguments)
            assert result.exception is None or isinstance(result.exception, SystemExit), size
            assert result.exit_code == 0 or "Error: " in result.output


def test_truncated_here_and_there(good, tmp_path):
    size = (good / "run_0.mcap").stat().st_size
    truncated(good, tmp_path, [*range(0, 200, 7), *np.linspace(200, size, 60, dtype=int)])


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_truncated_at_every_byte(tmp_path):
    """Of a bag as small as it gets: a body, two steps, no outputs."""
    scene = rb.Scene.from_yaml("bodies:\n  - {name: a, mass: 1, shape: {type: particle}}\n")
    world = scene.build()
    table = dataclasses.replace(load_topics(), entries=())
    with Recorder(world, tmp_path / "small" / "run", scene=scene, topics=table) as recorder:
        for _ in range(2):
            world.step()
            recorder.after_step()
    path = tmp_path / "small" / "run" / "run_0.mcap"
    (tmp_path / "copies").mkdir()
    truncated(tmp_path / "small" / "run", tmp_path / "copies", range(path.stat().st_size))


def said(*arguments: object) -> str:
    """The one sentence a command fails with."""
    result = CliRunner().invoke(main, [str(a) for a in arguments])
    assert result.exit_code == 1, result.output
    return result.output.splitlines()[-1]


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n"], ids=["no bytes", "magic only"])
@pytest.mark.parametrize("with_metadata", [True, False])
def test_an_empty_file_is_called_empty(good, tmp_path, content, with_metadata):
    run = Path(shutil.copytree(good, tmp_path / "run"))
    (run / "run_0.mcap").write_bytes(content)
    if not with_metadata:
        (run / "metadata.yaml").unlink()
    for command in ("info", "verify"):
        assert "empty or damaged" in said(command, run)
    assert "empty or damaged" in said("export", run, tmp_path / "tables")
    if importlib.util.find_spec("matplotlib"):
        assert "empty or damaged" in said("plot", run, tmp_path / "a.png")


def test_a_folder_in_the_place_of_a_file_is_called_one(good, tmp_path):
    run = Path(shutil.copytree(good, tmp_path / "run"))
    (run / "run_0.mcap").unlink()
    (run / "run_0.mcap").mkdir()
    for command in ("info", "verify", "recover"):
        assert "run_0.mcap is a folder; it should be an MCAP file" in said(command, run)


def test_results_that_cannot_be_written_say_where(good, tmp_path):
    (tmp_path / "file").write_text("")
    assert "can't be written (Not a directory)" in said(
        "export", good, tmp_path / "file" / "tables"
    )
    pytest.importorskip("matplotlib", reason="plots need matplotlib, which is optional")
    for command in (
        lambda png: said("plot", good, png),
        lambda png: said("view", good, "--png", png),
        lambda png: said("compare", good, good, "--plot", png),
    ):
        assert "nowhere does not exist: make it first" in command(tmp_path / "nowhere" / "a.png")
        assert "file is a file, not a folder" in command(tmp_path / "file" / "a.png")
