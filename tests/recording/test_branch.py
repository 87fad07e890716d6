"""Branches of a recording, comparison, export and plots."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from click.testing import CliRunner
from push_and_drop import SCENE

import rb_physics as rb
from rb_physics.cli import main
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.branch import AddedWrench, branch
from rb_physics.recording.compare import compare, differences
from rb_physics.recording.export import export
from rb_physics.recording.plot import plot, plot_comparison
from rb_physics.recording.replay import Run, verify
from rb_physics.recording.tables import read_tables
from rb_physics.recording.topics import parse_topics


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = tmp_path_factory.mktemp("recordings") / "run"
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, directory, scene=scene, snapshot_interval=0.1) as recorder:
        for step in range(200):
            if step == 120:
                recorder.perform("apply_wrench", body="box", force=(30, 0, 0), duration=0.1)
            if step == 180:
                recorder.perform("reset_state")
            world.step()
            recorder.after_step()
    return directory


def test_unchanged_branch_repeats_the_recording(run, tmp_path):
    assert branch(run, tmp_path / "branch", 0.15, rerun="off") == 125
    a, b = Run(run), Run(tmp_path / "branch")
    assert b.hashes.tolist() == a.hashes[75:].tolist()
    result = compare(run, tmp_path / "branch")
    assert result.identical
    assert (result.start, result.end) == (0.15, 0.4)
    assert "the first goes from 0.000 to 0.400 s, the second from 0.150 to 0.400 s" in result.text
    assert verify(tmp_path / "branch").text.endswith("identical, 125 steps, 0.25 s")


def test_a_branch_with_another_wrench_parts_where_it_begins(run, tmp_path):
    added = [AddedWrench("box", (40.0, 0.0, 0.0))]
    branch(run, tmp_path / "branch", 0.1, 0.3, wrenches=added, rerun="off")
    result = compare(run, tmp_path / "branch")
    parted = {b.body: b.parts_at for b in result.bodies}
    assert parted == {"ground": None, "box": 0.11, "ball": None}
    assert "they part at 0.110 s, body box first" in result.text
    [box] = [b for b in result.bodies if b.body == "box"]
    # Friction 0.5 m g of 2 kg leaves (40 - 9.81) N: a t^2 / 2 after 0.2 s, until the recorded push.
    assert box.largest_distance > 0.25
    assert verify(tmp_path / "branch").difference is None


def test_a_branch_goes_on_behind_the_end(run, tmp_path):
    assert branch(run, tmp_path / "branch", 0.4, 0.5, rerun="off", impact_law="sequential") == 50
    run_of_branch = Run(tmp_path / "branch")
    assert run_of_branch.settings["impact_law"] == "sequential"
    assert run_of_branch.notes["branch_of"] == "run"
    assert verify(tmp_path / "branch").difference is None


@pytest.mark.parametrize(
    ("start", "until", "settings", "words"),
    [
        (-1.0, None, {}, "goes from 0 to 0.4"),
        (0.5, None, {}, "goes from 0 to 0.4"),
        (0.2, 0.2, {}, "later than start"),
        (0.2, 0.3, {"dt": 0.001}, "dt can't be changed"),
    ],
)
def test_impossible_branches_say_so(run, tmp_path, start, until, settings, words):
    with pytest.raises(RecordingError, match=words):
        branch(run, tmp_path / "branch", start, until, **settings)
    assert not (tmp_path / "branch").exists()


def guest(name: str, x: float) -> dict:
    shape = {"type": "box", "half_extents": [0.1, 0.1, 0.1]}
    return {"name": name, "shape": shape, "mass": 1.0, "position": [x, 0.5, 0.2]}


@pytest.mark.parametrize("start", [0.04, 0.1, 0.14, 0.2, 0.3])
def test_a_branch_after_bodies_came_and_went_repeats_the_recording(tmp_path, start):
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene, snapshot_interval=0.06) as recorder:
        for step in range(200):
            if step == 20:
                recorder.perform("add_body", description=guest("crate", 0.5))
                recorder.perform("remove_body", body="ball")
            if step == 30:
                recorder.perform(
                    "add_body", description=guest("ball", -0.5)
                )  # another of that name
                recorder.perform("change_body", body="box", friction=0.1)
            if step == 60:
                recorder.perform("remove_body", body="crate")
                recorder.perform("apply_wrench", body="box", force=(4, 0, 0))
            if step == 90:
                recorder.perform("reset", keep_spawned=True)
            if step == 120:
                recorder.perform("add_body", description=guest("late", 2.0))
            if step == 160:
                recorder.perform("reset_state")
            world.step()
            recorder.after_step()
    run = tmp_path / "run"
    assert verify(run).difference is None
    steps = branch(run, tmp_path / "branch", start, rerun="off")
    a, b = Run(run), Run(tmp_path / "branch")
    assert steps == len(b.hashes) == 200 - round(start / 0.002)
    assert b.hashes.tolist() == a.hashes[-steps:].tolist()
    assert verify(tmp_path / "branch").difference is None
    assert compare(run, tmp_path / "branch").text.endswith("identical poses")


def test_tables_hold_what_was_published(run):
    tables = read_tables(run)
    assert tables.bodies == ["ground", "box", "ball"]
    assert len(tables.poses) == 3 * 41
    box = tables.wrenches[tables.wrenches["body"] == 1]
    resting = box[(box["time"] > 0.1) & (box["time"] < 0.23)]
    assert np.allclose(resting["force"], [0, 0, 2 * 9.81], atol=1e-8)  # contact solver's tolerance
    assert set(tables.contacts["body_b"]) == {0}
    assert tables.totals["time"][-1] == 0.4


@pytest.mark.parametrize("format", ["csv", "parquet", "npz"])
def test_export(run, tmp_path, format):
    if format == "parquet":
        pytest.importorskip("pyarrow")
    files = export(run, tmp_path / "out", format)
    assert [f.name for f in files] == [
        f"{n}.{format}" for n in ("poses", "wrenches", "contacts", "totals")
    ]
    poses = read_tables(run).poses
    if format == "csv":
        rows = list(csv.DictReader(files[0].read_text().splitlines()))
        heights = [float(row["position_z"]) for row in rows]
        assert {row["body"] for row in rows} == {"ground", "box", "ball"}
    elif format == "parquet":
        import pyarrow.parquet

        heights = pyarrow.parquet.read_table(files[0]).column("position_z").to_pylist()
    else:
        heights = np.load(files[0])["position"][:, 2].tolist()
    assert heights == poses["position"][:, 2].tolist()  # to the bit, CSV too
    with pytest.raises(RecordingError, match="never overwritten"):
        export(run, tmp_path / "out", format)


def test_export_tells_topic_and_frame_and_writes_short_numbers(run, tmp_path):
    files = {f.stem: f for f in export(run, tmp_path / "out")}
    rows = list(csv.DictReader(files["wrenches"].read_text().splitlines()))
    assert {(r["body"], r["topic"], r["frame"]) for r in rows} == {
        (name, f"/sim_node/bodies/{name}/contact_wrench", f"{name}/com") for name in ("box", "ball")
    }
    rows = list(csv.DictReader(files["contacts"].read_text().splitlines()))
    contacts = read_tables(run).contacts
    assert [np.float32(row["x"]) for row in rows] == contacts["x"].tolist()  # to the bit
    assert max(len(row["x"]) for row in rows) <= 15  # single precision: 9 digits and what surrounds


def test_wrenches_of_several_topics_of_a_body_are_kept_apart(tmp_path):
    table = parse_topics(
        """topics:
  - {name: ~/poses, content: poses, type: geometry_msgs/msg/PoseArray, direction: out}
  - {name: ~/body_names, content: body_names, type: std_msgs/msg/String, direction: out}
  - {name: ~/bodies/NAME/contact_wrench, content: contact_wrench, type: geometry_msgs/msg/WrenchStamped, direction: out}
  - {name: ~/bodies/NAME/sensor, content: contact_wrench, type: geometry_msgs/msg/WrenchStamped, direction: out, frame: world, reference_point: world}
  - {name: ~/bodies/NAME/contact_wrench/OTHER, content: pair_wrench, type: geometry_msgs/msg/WrenchStamped, direction: out, others: all}
"""
    )
    scene = rb.load_scene("single_box")
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene, topics=table) as recorder:
        for _ in range(10):
            world.step()
            recorder.after_step()
    tables = read_tables(tmp_path / "run")
    assert tables.frames == ["box/com", "world", "box/com"]
    assert [topic.split("/", 3)[3] for topic in tables.topics] == [
        "box/contact_wrench", "box/sensor", "box/contact_wrench/ground"]  # fmt: skip
    for topic in range(3):
        rows = tables.wrenches[tables.wrenches["topic"] == topic]
        assert len(rows) == 11
        assert np.allclose(rows["force"][1:, 2], 9.81, atol=1e-8)  # contact solver's tolerance
    pytest.importorskip("matplotlib")
    assert plot(tmp_path / "run", tmp_path / "run.png").stat().st_size > 5_000


def test_replay_command_takes_settings_torques_and_several_forces(run, tmp_path):
    arguments = ["replay", str(run), "--from", "0.1", "--until", "0.15", "--no-rerun"]
    arguments += ["--wrench", "ball", "1", "0", "0", "--wrench", "ball", "0", "2", "0"]
    arguments += ["--torque", "ball", "0", "0", "0.1"]
    arguments += ["--set", "gravity", "[0, 0, -1.6]", "--set", "threads", "2"]
    result = CliRunner().invoke(main, [*arguments, "--record", str(tmp_path / "b")])
    assert result.exit_code == 0, result.output
    other = Run(tmp_path / "b")
    assert other.settings["gravity"] == [0, 0, -1.6]
    forces = [o.arguments["force"] for o in other.operations if o.name == "apply_wrench"]
    assert forces == [[1, 0, 0], [0, 2, 0], [0, 0, 0]]
    assert len({o.arguments["source"] for o in other.operations}) == 3  # they add up
    assert verify(tmp_path / "b").difference is None
    for wrong, words in (
        (["--wrench", "nobody", "1", "0", "0"], "no dynamic body 'nobody' to push; there are box, ball"),
        (["--wrench", "ground", "1", "0", "0"], "no dynamic body 'ground'"),
        (["--torque", "ball", "nan", "0", "0"], "must be finite"),
        (["--set", "gravty", "[0, 0, 1]"], "gravty"),
        (["--set", "gravity", "[0,"], "no YAML value"),
        (["--set", "gravity", "down"], "gravity"),
    ):  # fmt: skip
        result = CliRunner().invoke(main, [*arguments, *wrong, "--record", str(tmp_path / "c")])
        assert result.exit_code != 0
        assert words in result.output, result.output
        assert not (tmp_path / "c").exists()


def test_plot(run, tmp_path):
    pytest.importorskip("matplotlib")
    path = plot(run, tmp_path / "run.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(RecordingError, match="never overwritten"):
        plot(run, path)


def test_plot_of_a_comparison(run, tmp_path):
    pytest.importorskip("matplotlib")
    branch(run, tmp_path / "b", 0.1, 0.3, wrenches=[AddedWrench("box", (40.0, 0, 0))], rerun="off")
    time, distance, _ = differences(run, tmp_path / "b")["box"]["position"]
    assert distance[time == 0.1] == 0
    assert distance[-1] > 0.25
    assert plot_comparison(run, tmp_path / "b", tmp_path / "a.png").stat().st_size > 10_000
    assert plot_comparison(run, run, tmp_path / "same.png").stat().st_size > 5_000
    with pytest.raises(RecordingError, match="never overwritten"):
        plot_comparison(run, run, tmp_path / "same.png")
