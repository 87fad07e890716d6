"""The parameters of the log reach the bag."""

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from harness import wait_for
from mcap.reader import make_reader

from rb_physics.recording.log_reader import Recording
from rb_physics.recording.replay import Run, verify


@pytest.mark.parametrize("policy", ["block", "drop_oldest"])
def test_files_are_split_compressed_and_hold_snapshots_as_asked(simulator, tmp_path, policy):
    sim = simulator(
        record_dir=tmp_path / "runs", duration=1.0, snapshot_interval=0.2, log_split_duration=0.3,
        log_compression="lz4", log_chunk_bytes=10_000, log_queue_bytes=1_000_000,
        log_fsync=True, log_split_bytes=0, log_policy=policy,
    )  # fmt: skip
    assert sim.node.wait() == 0, sim.node.output
    (run,) = (tmp_path / "runs").iterdir()
    files = Recording(run).files
    assert len(files) == 4  # each holds 0.3 s of 1.0 s
    with open(files[0], "rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert {chunk.compression for chunk in chunks} == {"lz4"}
    assert sorted(Run(run).snapshots) == [0, 200, 400, 600, 800, 1000]
    assert verify(run).difference is None


def test_the_log_of_a_node_on_a_full_disk_ends_and_the_simulation_goes_on(simulator, small_disk):
    mount, _ = small_disk
    sim = simulator(scene="hundred_bodies", record_dir=mount / "runs")
    diagnostics = sim.client.collect(DiagnosticArray, "/sim_node/diagnostics")
    poses = sim.client.collect(PoseArray, "/sim_node/poses")

    def told():
        statuses = [s for m in diagnostics for s in m.status if s.name == "sim_node: log"]
        return [s for s in statuses if s.level == b"\x02" and "is full" in s.message]

    wait_for(told, "an ERROR in the diagnostics")
    seen = len(poses)
    wait_for(lambda: len(poses) > seen + 20, "the simulation to go on")
    assert sim.node.stop() == 0, sim.node.output
    (run,) = (mount / "runs").iterdir()
    assert Recording(run).files
    assert verify(run).difference is None
