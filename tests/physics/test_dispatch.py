"""The accuracy table has the same bits whatever the processor offers and however many threads there
are: the C library's variants of sin, exp, pow, ..., the instruction set of the wide loops, threads."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rb_physics._core import solver

ROOT = Path(__file__).resolve().parents[2]
# Plays every row of the table and a pile, and prints what each ended in.
PROGRAM = """
import hashlib, math, struct, sys
sys.path[:0] = {path!r}
threads = int(sys.argv[1])

from benchmarks import accuracy
from benchmarks.stage import Stage
from rb_physics._core import solver
from test_wide_sweeps import hashes, pile

bits = [g(0.37 * k) for g in (math.sin, math.cos, math.exp) for k in range(1, 1800)]
print("libm", hashlib.sha256(struct.pack(f"{{len(bits)}}d", *bits)).hexdigest())
print("level", solver.simd_level())

worlds = []
make = Stage.world
def recorded(stage, *args, **settings):
    worlds.append(make(stage, *args, **settings))
    return worlds[-1]
Stage.world = recorded
for row in accuracy.ROWS:
    for stepper in row.steppers:
        worlds.clear()
        row.run(Stage(stepper=stepper, settings={{"threads": threads}}))
        assert worlds
        print("row", row.name, stepper, *(f"{{w.state_hash:x}}" for w in worlds))
print("row pile", *hashes(pile(threads)))
"""
# How glibc spells its switches differs between versions.
MASKED = [
    "-FMA,-AVX2,-FMA4,-AVX512F",
    "-FMA_Usable,-AVX2_Usable,-FMA4_Usable,-AVX512F_Usable",
]


def play(threads: int, level: str = "", masked: str = "") -> dict[str, list[str]]:
    path = [str(ROOT), str(ROOT / "tests" / "solver")]
    environment = {**os.environ, "RB_PHYSICS_SIMD": level}
    if masked:
        environment["GLIBC_TUNABLES"] = f"glibc.cpu.hwcaps={masked}"
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(path=path), str(threads)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    found: dict[str, list[str]] = {"libm": [], "level": [], "row": []}
    for line in done.stdout.splitlines():
        kind, rest = line.split(" ", 1)
        found[kind].append(rest)
    return found


@pytest.fixture(scope="module")
def plain() -> dict[str, list[str]]:
    return play(threads=1)


def masked_libm(plain: dict[str, list[str]]) -> str:
    """Switches under which this machine's libm computes other bits, or a skip that says why not."""
    program = PROGRAM[: PROGRAM.index('print("level"')].format(path=[str(ROOT)])
    program = "\n".join(
        line for line in program.splitlines() if "import" not in line or "math" in line
    )
    for switches in MASKED:
        bits = subprocess.run(
            [sys.executable, "-c", program, "1"],
            env={**os.environ, "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={switches}"},
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        ).stdout.split()[1]
        if [bits] != plain["libm"]:
            return switches
    pytest.skip("the C library has no other variants here: no FMA, or not glibc")


def test_without_fma_and_avx2_in_the_c_library(plain, capsys):
    switches = masked_libm(plain)
    other = play(threads=2, masked=switches)
    assert other["libm"] != plain["libm"]  # the switches did something
    with capsys.disabled():
        print(f"\nlibm's sin, cos and exp differ under {switches}; the core's bits do not")
    assert other["row"] == plain["row"]


@pytest.mark.parametrize(("level", "threads"), [("base", 4), ("avx2", 1), ("avx512", 2)])
def test_at_another_dispatch_level(plain, level, threads, capsys):
    if not solver.simd_levels().get(level, False):
        with capsys.disabled():
            print(f"\nSIMD level not run, this machine has none: {level}")
        pytest.skip(f"no {level} here")
    other = play(threads, level)
    assert other["level"] == [level]
    assert other["row"] == plain["row"]
    assert len(plain["row"]) == 41  # every row of the table, with every stepper, and the pile
