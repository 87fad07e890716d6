"""A process that uses another DDS implementation pushes a body and sees it move."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="PyPI cyclonedds is not installed (extra `test`)")

# Unconfigured, Cyclone DDS looks for others by multicast, which ROS leaves out for LOCALHOST.
CYCLONE = (
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo'/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto"
    "</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers>"
    "<Peer address='127.0.0.1'/></Peers></Discovery></Domain></CycloneDDS>"
)


def run_peer(script, domain, *arguments):
    """What a process with Cyclone DDS says it has seen."""
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name(script)), *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain), "CYCLONEDDS_URI": CYCLONE},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_cyclone_dds_pushes_the_floater_and_sees_it(simulator, domain):
    simulator()
    topics = ["rt/sim_node/bodies/floater/wrench", "rt/sim_node/poses"]
    seen = run_peer("cyclone_peer.py", domain, *topics, "2", "40")
    assert seen["first"] == 3.0  # nothing moves it sideways before the wrench
    assert seen["last"] > 3.05


def test_cyclone_dds_adds_a_body_pushes_it_in_a_batch_and_removes_it(simulator, domain):
    simulator()
    seen = run_peer("cyclone_spawner.py", domain, "sim_node", "40")
    assert (seen["first"], seen["spawned"], seen["removed"]) == (3, 4, 3)
    assert seen["pushed"] > 7.1
