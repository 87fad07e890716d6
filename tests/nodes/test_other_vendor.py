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


def test_cyclone_dds_pushes_the_floater_and_sees_it(simulator, domain):
    simulator()
    peer = Path(__file__).with_name("cyclone_peer.py")
    topics = ["rt/sim_node/bodies/floater/wrench", "rt/sim_node/poses"]
    done = subprocess.run(
        [sys.executable, str(peer), *topics, "2", "40"],
        capture_output=True,
        text=True,
        timeout=60,
        env={**os.environ, "ROS_DOMAIN_ID": str(domain), "CYCLONEDDS_URI": CYCLONE},
    )
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert seen["first"] == 3.0  # nothing moves it sideways before the wrench
    assert seen["last"] > 3.05
