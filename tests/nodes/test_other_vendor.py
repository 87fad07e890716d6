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


def test_cyclone_dds_drives_a_body_hears_the_clock_and_feels_what_it_pushes(
    simulator, domain, tmp_path
):
    """A kinematic pusher moves a 2 kg crate at constant speed against friction 0.5 · 2 · 10 N."""
    scene = tmp_path / "push.yaml"
    scene.write_text(
        """
gravity: [0, 0, -10]
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}, friction: 0.5}
  - {name: arm, type: kinematic, shape: {type: box, half_extents: [0.1, 0.1, 0.05]}, position: [0, 0, 0.1], friction: 0}
  - {name: crate, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0.21, 0, 0.1], friction: 0.5}
"""
    )
    simulator(scene=scene)
    seen = run_peer("cyclone_robot.py", domain, "sim_node", "arm", "1", "40")
    assert seen["names"] == ["ground", "arm", "crate"]
    assert seen["times"] == sorted(seen["times"]) and len(seen["times"]) > 10
    assert seen["x"][0] == 0.0 and seen["x"][-1] > 0.3
    # The crate pushes back; 1e-9: the solver's residual. Means over intervals that begin with the
    # impact are left out.
    assert seen["forces"][-1] == pytest.approx(-10.0, abs=1e-9)


def test_cyclone_dds_calls_a_service_and_hears_the_answer(simulator, domain):
    """By the two topics a service is made of: Fast DDS answers requests that lack what ROS adds to them.

    Bare Cyclone DDS stands for the other vendor; calls between nodes of two ROS middlewares are not tried.
    """
    simulator()
    answers = run_peer("cyclone_caller.py", domain, "sim_node", "30")
    assert [success for success, _ in answers] == [True, True]
    assert answers[0][1].startswith("paused") and answers[1][1].startswith("running")
