"""A step asks for no memory once it has warmed up: no jitter, no growth."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

COUNTER = Path(__file__).with_name("malloc_counter.c")

SCENES = """
import ctypes
import numpy as np
import rb_physics as rb

count = ctypes.CDLL(None).malloc_count
count.restype = ctypes.c_ulong
box = rb.Box((0.1, 0.1, 0.1))

def world(**settings):
    world = rb.World(**settings)
    world.add_body(rb.HalfSpace((0, 0, 1), 0), type="static", restitution=0.5)
    return world

def boxes_at_rest():
    w = world()
    for k in range(20):
        w.add_body(box, mass=1.0, position=(k, 0, 0.1))
    return w

def tower():
    w = world(dt=5e-3)
    for k in range(10):
        w.add_body(box, mass=1.0, position=(0, 0, 0.1 + 0.2 * k))
    return w

def pushed():
    w = boxes_at_rest()
    for body in w.bodies[1:]:
        body.apply_wrench((0.5, 0, 0), (0, 0, 0))
    return w

def flying():
    w = world(gravity=(0, 0, 0))
    for k in range(20):
        w.add_body(box, mass=1.0, position=(k, 0, 5), angular_velocity=(1, 2, 3))
    return w

def threads():
    w = world(threads=2)
    for k in range(40):  # they tumble first: islands that take so long that every thread gets some
        tilt = np.array([1.0, 0.1 + 0.01 * k, 0.2, 0.0])
        w.add_body(box, mass=1.0, position=(k, 0, 0.3), orientation=tilt / np.linalg.norm(tilt))
    return w

w = {name}()
w.step(500)  # until every thread has solved an island anew
before = count()
w.step(100)
print((count() - before) / 100)
"""


@pytest.fixture(scope="module")
def counter(tmp_path_factory) -> Path:
    built = tmp_path_factory.mktemp("malloc") / "counter.so"
    made = subprocess.run(
        ["cc", "-O1", "-shared", "-fPIC", "-o", str(built), str(COUNTER)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    if made.returncode != 0:  # another C library
        pytest.skip(f"no counter of malloc here: {made.stderr[:200]}")
    return built


@pytest.mark.parametrize("name", ["boxes_at_rest", "tower", "pushed", "flying", "threads"])
def test_a_step_allocates_nothing_after_warm_up(counter: Path, name: str) -> None:
    import os

    code = textwrap.dedent(SCENES).replace("{name}", name)
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "LD_PRELOAD": str(counter)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    if "malloc_count" in done.stderr:
        pytest.skip("preloading is not possible here")
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[-1]) == 0.0
