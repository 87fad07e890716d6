"""`make demo` works: exit code 0, and a bag and a Rerun recording are left."""

import subprocess
import sys

from rosbags.highlevel import AnyReader


def test_the_demo_ends_well_and_leaves_its_recording(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "rb_physics_nodes.demo", "--record-dir", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    for words in ("m g:", "the ball hits it at:", "real-time factor:", "dropped:"):
        assert words in done.stdout
    (run,) = tmp_path.iterdir()
    with AnyReader([run]) as reader:
        topics = {connection.topic for connection in reader.connections}
        assert {"/clock", "/sim_node/poses", "/sim_node/bodies/ball/wrench"} <= topics
        assert reader.end_time == 10 * 10**9 + 1  # rosbags gives the end exclusively
    assert list(run.glob("*.rrd"))
