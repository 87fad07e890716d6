"""Threads share islands and pairs; nothing they compute depends on how many there are."""

import gc
import os
import sys

import numpy as np
import pytest

import rb_physics as rb


def crowd(threads: int, **settings) -> rb.World:
    """Bouncing, rolling, stacked and pushed bodies: many islands, one of them large."""
    world = rb.World(dt=5e-3, threads=threads, **settings)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", restitution=0.4)
    for k in range(2):
        world.add_body(
            rb.Box((1.0, 0.1, 0.1)),
            type="kinematic",
            position=(4.0 * k, 0, 0.3),
            angular_velocity=(0, 0, 3.0),
        )
    random = np.random.default_rng(5)
    shapes = [
        rb.Box((0.1, 0.1, 0.05)),
        rb.Sphere(0.1),
        rb.Capsule(0.05, 0.1),
        rb.Cylinder(0.1, 0.1),
        rb.ConvexHull(
            0.12 * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
        ),
    ]
    for k in range(100):
        q = random.normal(size=4)
        world.add_body(
            shapes[k % 5],
            mass=1.0,
            position=(*random.uniform(-1, 5, 2), random.uniform(0.15, 0.35)),
            orientation=q / np.linalg.norm(q),
            restitution=0.2 * (k % 3),
        )
    return world


def hashes(world: rb.World, steps: int) -> list[int]:
    found = []
    for _ in range(steps):
        world.step()
        found.append(world.state_hash)
    return found


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_bits_do_not_depend_on_the_number_of_threads(stepper: str) -> None:
    steps = 60 if stepper == "fixed" else 40
    alone = crowd(1, stepper=stepper)
    wanted = hashes(alone, steps)
    assert alone.stats.contacts > 64  # enough to be shared out
    assert alone.stats.islands > 10
    for threads in (2, 3, 4):
        assert hashes(crowd(threads, stepper=stepper), steps) == wanted


def test_statistics_do_not_depend_on_the_number_of_threads() -> None:
    one, four = crowd(1), crowd(4)
    for _ in range(40):
        one.step()
        four.step()
        for field in (
            "residual",
            "iterations",
            "contacts",
            "islands",
            "events",
            "impacts",
            "capped",
        ):
            assert getattr(one.stats, field) == getattr(four.stats, field), field


@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
def test_a_forked_process_steps_on_without_its_threads() -> None:
    """The helpers do not survive a fork; the caller does their work."""
    world, twin = crowd(4), crowd(4)
    hashes(world, 40)
    wanted = hashes(twin, 60)
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:  # pragma: no cover
        try:
            found = hashes(world, 20)
            del world, twin  # pools whose threads are gone can be destroyed
            gc.collect()
            os.write(theirs, b"same" if found == wanted[40:] else b"other")
        finally:
            os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        assert pipe.read() == b"same"
    os.waitpid(child, 0)
