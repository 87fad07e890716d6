"""What a body and a contact take in memory, and that steps take none."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/statm")

COMMON = """
import os
import rb_physics as rb

def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGESIZE")

box = rb.Box((0.1, 0.1, 0.1))

def world(bodies, height):
    w = rb.World(dt=1e-3)
    w.add_body(rb.HalfSpace((0, 0, 1), 0), type="static")
    for k in range(bodies):
        w.add_body(box, mass=1.0, position=(k % 100, k // 100, height))
    return w
"""


def run(code: str, timeout: float) -> list[float]:
    done = subprocess.run(
        [sys.executable, "-c", COMMON + code], capture_output=True, text=True, timeout=timeout
    )
    assert done.returncode == 0, done.stderr
    return [float(word) for word in done.stdout.split()]


@pytest.mark.skipif(
    "asan" in os.environ.get("LD_PRELOAD", ""), reason="the sanitizer pads every allocation"
)
def test_a_body_takes_2_kib_and_a_contact_1_kib() -> None:
    code = """
world(100, 0.1).step(20)  # what is loaded on first use
n = 10_000
for height in (50.0, 0.1):
    before = resident()
    w = world(n, height)
    w.step(20)
    print((resident() - before) / n)
    del w
"""
    flying, resting = run(code, 120)
    # Measured 1.9 KiB and 0.8 KiB; vectors grow by doubling.
    assert flying < 2.5 * 1024
    assert (resting - flying) / 4 < 1.5 * 1024


@pytest.mark.soak
def test_a_million_steps_take_no_memory() -> None:
    code = """
w = world(4, 0.1)
for k in range(4):
    w.add_body(box, mass=1.0, position=(k, 0, 0.3))
w.add_body(box, mass=1.0, position=(9, 9, 1e9), angular_velocity=(1, 2, 3))
w.step(50_000)
before = resident()
w.step(1_000_000)
print(resident() - before)
"""
    (growth,) = run(code, 600)
    assert growth <= 64 * 1024  # pages the C library may touch late: nothing a step
