"""The same bits always: run to run, after restore elsewhere, in another process, on other dispatch."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import turn

SETTINGS = {
    "default": {},
    "event": {"stepper": "event"},
    "reflections": {"impact_law": "reflections"},
    "rk4": {"free_motion": "rk4"},
}


def build(**settings):
    """Impacts, sliding, rolling, a stack, a kinematic pusher, and a body that tumbles freely."""
    world = rb.World(dt=2e-3, **settings)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.4)
    pusher = world.add_body(
        rb.Box((0.1, 0.6, 0.1)), type="kinematic", position=(-1.2, 0, 0.11), name="pusher"
    )
    pusher.linear_velocity = (0.8, 0, 0)
    for k in range(4):
        world.add_body(rb.Box((0.1, 0.12, 0.1)), mass=1.0 + k, position=(0, 0, 0.1 + 0.2 * k))
    for k in range(4):
        world.add_body(
            rb.Sphere(0.08),
            mass=0.5,
            position=(0.3 * k - 0.5, 0.5, 0.4 + 0.1 * k),
            linear_velocity=(0.3, -1.0, 0.1 * k),
            angular_velocity=(1, 2, 3),
            restitution=0.6,
        )
    world.add_body(
        rb.Box((0.1, 0.2, 0.3)),
        mass=2.0,
        position=(1.5, 0.3, 0.8),
        orientation=turn((1, 2, 3), 0.4),
        angular_velocity=(3, -2, 5),
    )
    return world


def hashes(world, steps=100):
    out = []
    for n in range(steps):
        if n == 60:
            world.bodies[3].apply_wrench(force=(2, 1, 0), duration=0.05)
        world.step()
        out.append(world.state_hash)
    return out


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_run_to_run(settings):
    assert hashes(build(**settings)) == hashes(build(**settings))


def test_hash_tells_states_apart():
    world = build()
    seen = set(hashes(world, 100))
    assert len(seen) == 100
    world.bodies[4].position = world.bodies[4].position + (1e-15, 0, 0)
    assert world.state_hash not in seen


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("at", [0, 57, 75])
def test_restored_in_another_world(settings, at):
    """Saved in the midst of things (an applied wrench among them) and carried on elsewhere."""
    world = build(**settings)
    before = hashes(world, at)
    snapshot = world.save()
    assert isinstance(snapshot, bytes)
    other = build(**settings)
    other.step(33)
    other.restore(snapshot)
    assert other.state_hash == world.state_hash == (before[-1] if at else build().state_hash)
    assert other.time == world.time
    assert other.save() == snapshot
    for _ in range(30):
        world.step()
        other.step()
        assert other.state_hash == world.state_hash
    np.testing.assert_array_equal(world.positions, other.positions)
    np.testing.assert_array_equal(world.contacts["force"], other.contacts["force"])


def test_reset_repeats_the_run():
    world = build()
    start = world.save()
    first = hashes(world, 100)
    world.restore(start)
    assert world.time == 0.0
    assert hashes(world, 100) == first


def test_steps_in_one_call_or_in_many():
    one, many = build(), build()
    one.step(50)
    for _ in range(50):
        many.step()
    assert one.state_hash == many.state_hash


def test_reading_changes_nothing():
    plain, read = build(), build()
    for _ in range(60):
        plain.step()
        read.step()
        _ = read.contacts, read.positions, read.kinetic_energy, read.stats.residual, read.state_hash
        rb.distance(read.bodies[3], read.bodies[0])
        rb.find_contacts(read.bodies[3], read.bodies[0])
        read.ray_cast((0, 0, 5), (0, 0, -1))
        assert plain.state_hash == read.state_hash


def test_a_world_does_not_depend_on_another():
    """Two worlds stepped in turns do what each does alone."""
    a, b, alone = build(), build(impact_law="reflections"), build()
    for _ in range(60):
        a.step()
        b.step()
        alone.step()
    assert a.state_hash == alone.state_hash


def test_threads_give_the_same_bits():
    assert hashes(build(threads=2), 100) == hashes(build(), 100)


PROGRAM = """
import sys
sys.path[:0] = {path!r}
from test_determinism import SETTINGS, build, hashes
for settings in SETTINGS.values():
    print(hashes(build(**settings), 70))
"""


def hashes_elsewhere(**environment):
    """The same run in another process."""
    here = Path(__file__).resolve().parent
    package = Path(rb.__file__).resolve().parents[1]
    path = [str(package), str(here), str(here.parents[1])]
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(path=path)],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return result.stdout


def test_another_process():
    here = "".join(f"{hashes(build(**s), 70)}\n" for s in SETTINGS.values())
    assert hashes_elsewhere(PYTHONHASHSEED="77") == here


# How glibc spells its switches differs between versions: older ones know AVX2_Usable, newer AVX2.
@pytest.mark.parametrize(
    "switches",
    [
        "-FMA,-AVX2,-FMA4",
        "-FMA_Usable,-AVX2_Usable,-FMA4_Usable",
        "-AVX512F,-AVX2,-FMA,-AVX,-SSE4_1",
    ],
)
def test_other_cpu_dispatch_of_the_c_library(switches):
    """No transcendental of libm in the core: other variants of sin, pow, ... change no bit."""
    here = "".join(f"{hashes(build(**s), 70)}\n" for s in SETTINGS.values())
    assert hashes_elsewhere(GLIBC_TUNABLES=f"glibc.cpu.hwcaps={switches}") == here
