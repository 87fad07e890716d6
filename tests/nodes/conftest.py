"""Fixtures of the node tests: a domain of its own, a scene and a running simulator per test."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import Client, Sim

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
_counter = itertools.count()


@pytest.fixture
def domain() -> int:
    """A ROS_DOMAIN_ID that neighbouring tests and test runs don't use (legal are 0 to 232)."""
    return 10 + (os.getpid() * 13 + next(_counter)) % 210


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
