"""The Rerun view: same from a run and from its bag, verified, rendered."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError
from rb_physics.recording.mcap_log import McapLog
from rb_physics.recording.render import render_png, write_rrd

rr = pytest.importorskip("rerun")

SCENE = """
dt: 0.001
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: box, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0, 0, 0.1]}
  - {name: ball, shape: {type: sphere, radius: 0.05}, mass: 0.5, position: [0.5, 0, 0.3], restitution: 0.5}
  - name: dumbbell
    shape:
      type: compound
      parts:
        - {shape: {type: sphere, radius: 0.05}, position: [-0.1, 0, 0]}
        - {shape: {type: box, half_extents: [0.05, 0.05, 0.05]}, position: [0.1, 0, 0]}
    mass: 1.0
    position: [0, 0.5, 0.3]
"""


@pytest.fixture(scope="module", autouse=True)
def strict():
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    directory = tmp_path_factory.mktemp("recordings") / "run"
    scene = rb.Scene.from_yaml(SCENE)
    world = scene.build()
    with Recorder(world, directory, scene=scene, rerun="file") as recorder:
        for step in range(400):
            if step == 100:
                recorder.perform("apply_wrench", body="box", force=(5, 0, 0), duration=0.2)
                recorder.event("WARN", "pushed")
            world.step()
            recorder.after_step()
        assert recorder.error is None
    assert recorder.counters["view_dropped"] == 0
    return directory


def command(*arguments) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "rerun", *map(str, arguments)],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip


def test_rerun_verifies_it_and_the_bag_gives_the_same(run, tmp_path):
    made = run / "run.rrd"
    done = command("rrd", "verify", made)
    assert done.returncode == 0, done.stderr
    again = write_rrd(run, tmp_path / "run.rrd")
    done = command("rrd", "verify", again)
    assert done.returncode == 0, done.stderr
    assert rows(made) == rows(again)  # but in chunks of other lengths


def rows(path) -> dict[str, list]:
    """entity and column -> its cells in order of time."""
    found: dict[str, list] = {}
    for entity, batches in columns(path).items():
        for batch in batches:
            names = batch.schema.names
            times = (
                batch.column("sim_time").cast("int64").to_pylist() if "sim_time" in names else []
            )
            for name in names:
                if name == "sim_time" or "RowId" in name:
                    continue
                cells = batch.column(name).to_pylist()
                pairs = zip(times or [-1] * len(cells), map(repr, cells), strict=True)
                found.setdefault(f"{entity} {name}", []).extend(pairs)
    return {key: sorted(cells) for key, cells in found.items() if not key.startswith("/__")}


def columns(path) -> dict[str, list]:
    """entity -> its record batches"""
    from rerun.chunk import RrdReader

    found: dict[str, list] = {}
    for chunk in RrdReader(str(path)).stream():
        found.setdefault(str(chunk.entity_path), []).append(chunk.to_record_batch())
    return found


def lines(found: dict[str, list]) -> list[str]:
    """The text log."""
    told = []
    for batch in found["/log"]:
        [name] = [n for n in batch.schema.names if n.endswith("text")]
        told += [text for cell in batch.column(name).to_pylist() for text in cell]
    return told


def test_what_is_in_it(run):
    found = columns(run / "run.rrd")
    for entity in (
        "/world/bodies/ground", "/world/bodies/box", "/world/bodies/dumbbell/part_0",
        "/world/bodies/dumbbell/part_1", "/world/contact_points", "/world/contact_forces",
        "/world/applied_forces",
        "/world/trajectories", "/plots/energy/total", "/plots/contact_force/ball", "/log",
    ):  # fmt: skip
        assert entity in found, f"{entity} not in {sorted(found)}"
    total = [b for b in found["/plots/energy/total"] if "sim_time" in b.schema.names]
    times = np.concatenate([b.column("sim_time").cast("int64").to_numpy() for b in total])
    assert np.array_equal(np.sort(times), np.arange(41) * 10_000_000)
    arrows = [b for b in found["/world/applied_forces"] if "sim_time" in b.schema.names]
    pushed = {}
    for batch in arrows:
        [name] = [n for n in batch.schema.names if "vectors" in n]
        stamps = batch.column("sim_time").cast("int64").to_numpy()
        pushed |= {
            int(t): len(v.as_py() or []) for t, v in zip(stamps, batch.column(name), strict=True)
        }
    with_arrow = sorted(t for t, count in pushed.items() if count)
    # The force acts from 0.1 s for 0.2 s; the sample of 0.1 s itself is of before.
    assert (with_arrow[0], with_arrow[-1]) == (110_000_000, 300_000_000)


def test_many_bodies_share_entities(tmp_path):
    world = rb.World()
    world.add_body(rb.HalfSpace(), type="static", name="ground")
    for i in range(60):
        shape = rb.Box((0.1, 0.1, 0.1)) if i % 2 else rb.Capsule(0.05, 0.1)
        world.add_body(shape, mass=1.0, position=(i, 0, 5), name=f"b{i}")
    with Recorder(world, tmp_path / "run", rerun="file") as recorder:
        for _ in range(30):
            world.step()
            recorder.after_step()
    found = columns(tmp_path / "run" / "run.rrd")
    assert {"/world/bodies/boxes", "/world/bodies/capsules", "/world/bodies/ground"} <= set(found)
    assert "/world/bodies/b1" not in found


def test_contacts_of_many_bodies_are_told_some_by_name_and_the_rest_by_number(tmp_path):
    """60 balls are let go 2 mm above the ground; half of them stay in the air."""
    world = rb.World()
    world.add_body(rb.HalfSpace(), type="static", name="ground")
    for i in range(60):
        height = 0.102 if i % 2 else 5.0
        world.add_body(rb.Sphere(0.1), mass=1.0, position=(i, 0, height), name=f"b{i}")
    with Recorder(world, tmp_path / "run", rerun="file") as recorder:
        for step in range(60):
            if step == 40:
                recorder.perform("apply_impulse", body="b1", impulse=(0, 0, 3))
            world.step()
            recorder.after_step()
    told = lines(columns(tmp_path / "run" / "run.rrd"))
    landed = [line for line in told if line.endswith(" touches ground")]
    assert len(landed) == 20 and "b1 touches ground" in landed
    assert "and 10 more pairs: one touches the other" in told
    assert "b1 leaves ground" in told


def test_contact_curves_do_not_begin_with_a_zero_that_was_never_measured(run):
    found = columns(run / "run.rrd")
    for entity in ("/plots/contact_force/box", "/plots/contacts/points", "/plots/solver/residual"):
        batches = [b for b in found[entity] if "sim_time" in b.schema.names]
        times = np.concatenate([b.column("sim_time").cast("int64").to_numpy() for b in batches])
        assert times.min() == 10_000_000, entity


def test_existing_files_and_foreign_bags_are_refused(run, tmp_path):
    with pytest.raises(RecordingError, match="never overwritten"):
        write_rrd(run, run / "run.rrd")
    (tmp_path / "a.png").write_bytes(b"")
    with pytest.raises(RecordingError, match="never overwritten"):
        render_png(run, tmp_path / "a.png")
    with pytest.raises(RecordingError, match=r"run\.rrd has its layout inside"):
        render_png(run / "run.rrd", tmp_path / "x.png", layout="debug")
    for moment in (float("nan"), -1.0):
        with pytest.raises(RecordingError, match="the time to show is"):
            render_png(run, tmp_path / "x.png", time=moment)
    with pytest.raises(RecordingError, match="none does not exist: make it first"):
        render_png(run, tmp_path / "none" / "a.png")
    McapLog(tmp_path / "foreign").close()
    with pytest.raises(RecordingError, match="not made by rb_physics"):
        write_rrd(tmp_path / "foreign", tmp_path / "x.rrd")


@pytest.mark.parametrize(
    "layout",
    ["overview", *(pytest.param(n, marks=pytest.mark.soak) for n in ("contact", "debug"))],
)
def test_rendered_without_a_screen(run, tmp_path, layout):
    image = pytest.importorskip("PIL.Image")
    try:
        reports = render_png(run, tmp_path / "run.png", time=0.2, layout=layout)
    except RecordingError as error:
        if "Vulkan" in str(error):
            pytest.skip("no Vulkan driver on this machine")
        raise
    assert reports == []
    picture = np.asarray(image.open(tmp_path / "run.png").convert("RGB")).reshape(-1, 3).astype(int)
    assert len(picture) == 1600 * 900
    red, green, blue = picture.T
    # The push uses half of the friction cone: its contact forces are the only amber in the scene
    # (but for two of the plots' thin curves), the applied force the only blue.
    assert np.sum((red > 180) & (green > 110) & (green < 190) & (blue < 70)) > 50
    assert np.sum((blue > 150) & (red < 60) & (green < 130)) > 50


def test_live_view_without_a_viewer_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("rb_physics.recording.rerun_log._VIEWER_PORT", 1)  # nobody listens there
    with pytest.raises(RecordingError, match="no Rerun viewer listens on port 1 .*`rerun`"):
        Recorder(rb.World(), tmp_path / "run", rerun="live")
    assert not (tmp_path / "run").exists()


def test_a_view_that_breaks_does_not_stop_the_bag(tmp_path):
    world = rb.World()
    world.add_body(rb.Sphere(0.1), mass=1.0, name="ball")
    with Recorder(world, tmp_path / "run", rerun="file") as recorder:
        recorder._view.write([("bodies", None, 0, b"not a message")])
        for _ in range(50):
            world.step()
            recorder.after_step()
    assert recorder.error is None
    assert "the Rerun view stopped" in (recorder.view_error or "")
    assert recorder.counters["messages"] > 10


def test_unknown_layout_says_what_is_known(run, tmp_path):
    with pytest.raises(RecordingError, match="not one of overview, contact, debug"):
        write_rrd(run, tmp_path / "x.rrd", layout="fancy")


def test_contacts_are_told_in_the_log(run, tmp_path):
    told = lines(columns(write_rrd(run, tmp_path / "x.rrd")))
    assert {"pushed", "box touches ground"} <= set(told)
    [bounce] = [line for line in told if line.startswith("ball bounces")]
    # Falling 0.25 m gives 2.215 m/s; with restitution 0.5 the impulse is 1.5 m v = 1.66 N s.
    assert bounce == "ball bounces: impulse 1.66 N s"
