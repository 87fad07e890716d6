"""Fixtures of the node tests: a domain of its own, a scene and a running simulator per test."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Client, NodeProcess, Sim, parameters

import rb_physics as rb
from rb_physics.recording import Recorder

SCENE = """
dt: 0.001
gravity: [0, 0, -10]
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}, friction: 0.5}
  - name: crate
    shape: {type: box, half_extents: [0.1, 0.1, 0.1]}
    mass: 2.0
    position: [0, 0, 0.1]
    friction: 0.5
    frames: {tip: {position: [0.1, 0, 0], orientation: [0, 0, 0, 1]}}
  - {name: floater, shape: {type: sphere, radius: 0.1}, mass: 1.0, position: [3, 0, 5000]}
"""
DOMAINS = range(1, 100)  # their ports lie below those that Linux hands out to anybody


@pytest.fixture
def domain() -> Iterator[int]:
    """A ROS_DOMAIN_ID of this test alone: no other test run on this machine gets it meanwhile."""
    folder = Path(tempfile.gettempdir()) / "rb_physics_test_domains"
    folder.mkdir(exist_ok=True)
    for k in range(len(DOMAINS)):
        number = DOMAINS[(os.getpid() + k) % len(DOMAINS)]
        try:
            with open(folder / str(number), "w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                yield number
                return
        except OSError:  # somebody else's
            continue
    pytest.fail(f"every ROS_DOMAIN_ID of {DOMAINS} is in use; {folder} holds the locks")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A 2 kg crate resting on the ground and a 1 kg ball high above it; g = 10 m/s²."""
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE)
    return path


class Simulators:
    """Starts simulators (parameters as keywords) and ends them after the test."""

    def __init__(self, domain: int, scene: Path) -> None:
        self._domain = domain
        self._scene = scene
        self._started: list[Sim] = []

    def __call__(self, **values: object) -> Sim:
        self._started.append(Sim(self._domain, values.pop("scene", self._scene), **values))
        return self._started[-1]

    def close(self) -> None:
        """End all that still run."""
        while self._started:
            self._started.pop().close()


@pytest.fixture
def simulator(domain: int, scene: Path) -> Iterator[Simulators]:
    """Call it with parameters to start a sim_node of the test's scene."""
    simulators = Simulators(domain, scene)
    yield simulators
    simulators.close()


@pytest.fixture
def client(domain: int) -> Iterator[Client]:
    """A client in the test's domain without a simulator of its own."""
    client = Client(domain)
    yield client
    client.close()


@pytest.fixture
def recording(scene, tmp_path):
    """One second of the test scene, made without a node."""
    loaded = rb.load_scene(scene)
    world = loaded.build()
    with Recorder(world, tmp_path / "run", scene=loaded) as recorder:
        for _ in range(1000):
            world.step()
            recorder.after_step()
    return tmp_path / "run"


@pytest.fixture
def replay(domain):
    started = []

    def start(**values):
        started.append(NodeProcess("rb_physics_nodes.replay_node", parameters(**values), domain))
        return started[-1]

    yield start
    for process in started:
        process.close()
