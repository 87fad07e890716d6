"""The npm packages with which Foxglove reads bags decode every message of ours."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.outputs import CONTACT_POINT

HERE = Path(__file__).parent / "npm"
INSTALLED = Path(__file__).resolve().parents[2] / "build" / "npm"  # kept between runs
INSTALL = ["npm", "install", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries", "0"]

pytestmark = pytest.mark.soak  # the first run installs packages


@pytest.fixture(scope="module")
def script() -> Path:
    """read.js beside its installed packages; skips where they can't be had."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        pytest.skip("needs node and npm")
    INSTALLED.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "read.js"):
        shutil.copy(HERE / name, INSTALLED / name)
    if not (INSTALLED / "node_modules" / "@mcap" / "core").is_dir():
        try:
            done = subprocess.run(
                INSTALL, cwd=INSTALLED, capture_output=True, text=True, timeout=180
            )
        except subprocess.TimeoutExpired:
            pytest.skip("npm could not install the readers in 180 s")
        if done.returncode != 0:
            pytest.skip(f"npm could not install the readers: {done.stderr.splitlines()[-1:]}")
    return INSTALLED / "read.js"


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
def test_every_message_is_decoded(tmp_path, script, compression):
    scene = rb.load_scene("demo")
    world = scene.build()
    with Recorder(world, tmp_path / "run", scene=scene, compression=compression) as recorder:
        recorder.perform("apply_wrench", body=world.bodies[-1].name, force=(1, 0, 0))
        recorder.event("INFO", "a line")
        for _ in range(300):
            world.step()
            recorder.after_step()
    done = subprocess.run(
        ["node", str(script), str(tmp_path / "run" / "run_0.mcap")],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["profile"] == "ros2"
    topics = found["topics"]
    counts = Counter(m.topic for m in Recording(tmp_path / "run").messages())
    assert {name: topic["count"] for name, topic in topics.items()} == counts
    poses = topics["/sim_node/poses"]
    assert poses["time"] == 300_000_000
    assert poses["last"]["header"]["stamp"] == {"sec": 0, "nanosec": 300_000_000}
    assert poses["last"]["header"]["frame_id"] == "world"
    for pose, position, orientation in zip(
        poses["last"]["poses"], world.positions, world.orientations, strict=True
    ):
        assert [pose["position"][axis] for axis in "xyz"] == position.tolist()  # to the bit
        assert [pose["orientation"][axis] for axis in "xyzw"] == orientation.tolist()
    step, state_hash = topics["/sim_node/state_hash"]["last"]["data"][-2:]
    assert (int(step), int(state_hash)) == (300, world.state_hash)
    assert topics["/sim_node/events"]["last"] == {"data": "INFO a line"}
    assert topics["/sim_node/contacts"]["last"]["point_step"] == CONTACT_POINT.itemsize
