"""Accuracy against exact answers, as a table: `make verify` or `python -m benchmarks.accuracy`.

Each row is a case with a known answer: what the best engine a user could pick instead reaches, what
we aim at, and what we reach here and now, with both steppers where both apply. Exits with 1 when a
figure falls short.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from . import accuracy_cases as cases
from .stage import Stage

RESIDUAL = 1e-8  # natural map, relative: ceiling of every contact solve of every case
ENERGY_GAIN = 1e-12  # of the kinetic energy before a contact solve


@dataclass(frozen=True)
class Row:
    """One line of the table. ``targets``: name of a figure -> the largest value that is good."""

    name: str
    exact: str
    field: str
    targets: dict[str, float]
    run: Callable[[Stage], dict[str, float]]
    steppers: tuple[str, ...] = ("fixed", "event")
    event_targets: dict[str, float] | None = None  # where `event` must be better
    residual: float = RESIDUAL

    def limits(self, stepper: str) -> dict[str, float]:
        chosen = self.event_targets if stepper == "event" and self.event_targets else self.targets
        return {**chosen, "residual": self.residual, "energy gain": ENERGY_GAIN}


BOTH, FIXED = ("fixed", "event"), ("fixed",)
DEGREE_30 = np.pi / 6

ROWS = (
    *(
        Row(
            f"free body, J = (1, 2, 3), dt {dt:g}",
            "E, L constant; closed form",
            field,
            {"energy": 1e-13, "L": 1e-14, "attitude (rad)": 1e-9},
            lambda s, dt=dt: cases.free_body(s, dt),
        )
        for dt, field in (
            (1e-3, "E 4e-13, 7e-11 rad (MuJoCo RK4)"),
            (1e-2, "E 1e-8, 1e-6 rad (MuJoCo RK4)"),
        )
    ),
    Row(
        "ball, eps 0.8",
        "apex k: eps^(2k)",
        "2e-3 (PhysX)",
        {"apex": 1e-6},
        cases.bouncing_ball,
        event_targets={"apex": 1e-12},
    ),
    Row(
        "ball, eps 1",
        "1 m for ever",
        "E 2e-4 (PhysX, ODE)",
        {"energy": 1e-10, "above the start": 1e-12},
        cases.elastic_ball,
    ),
    Row(
        "Newton's cradle, law reflections",
        "(0, 0, 0, 0, 1)",
        "0.38 (smallest)",
        {"velocities": 1e-12},
        cases.newtons_cradle,
    ),
    *(
        Row(
            f"box on an incline, tan a = {f:g} mu",
            "does not move",
            "1e-13 … 1e-4 m/s (many), 5e-4 (MuJoCo, PhysX)",
            {"creep (m/s)": 1e-12},
            lambda s, f=f: cases.box_on_incline(s, f),
        )
        for f in (0.9, 0.99)
    ),
    *(
        Row(
            f"box on an incline, tan a = {f:g} mu",
            "g (sin a - mu cos a) t²/2",
            "3e-4 (Jolt, DART)",
            {"distance": 1e-6, "velocity": 1e-6},
            lambda s, f=f: cases.box_down_incline(s, f),
        )
        for f in (1.01, 1.1)
    ),
    *(
        Row(
            f"box slides to rest, {name}",
            "v²/(2 mu g), straight",
            field,
            {"distance": 1e-6, "off (deg)": 1e-9},
            lambda s, h=heading: cases.box_slides_to_rest(s, h),
        )
        for name, heading, field in (
            ("along x", 0.0, "4e-4 (Rapier, Box3D)"),
            ("at 30 deg", DEGREE_30, "4e-4; ODE, DART -21 %, 11.6 deg off"),
        )
    ),
    Row(
        "sphere slides, then rolls",
        "5/7 v0",
        "3e-15 (ODE), 1e-6 (Jolt)",
        {"velocity": 1e-12, "slip": 1e-12},
        cases.sphere_starts_to_roll,
    ),
    Row(
        "tower of 10, dt 5 ms, 10 s",
        "weights, every step",
        "6e-11 m, sum 2e-14 (ODE exact); 4e-4 m (Jolt)",
        {"penetration (m)": 1e-9, "force sum": 1e-12, "corners": 1e-9, "jitter (N)": 1e-9},
        cases.tower,
        FIXED,
        residual=1e-12,
    ),
    Row(
        "tower of 30, dt 5 ms, 10 s",
        "stands",
        "1.4e-4 m (MuJoCo), 4e-4 m (PhysX); falls in 4",
        {"penetration (m)": 1e-6, "motion (m/s)": 1e-6},
        lambda s: cases.tower(s, 30),
        FIXED,
        residual=1e-12,
    ),
    Row(
        "sphere in a V groove, mu 0",
        "N = m g/(2 cos phi)",
        "5e-12 m (ODE), 7e-5 m (Rapier, Box3D)",
        {"N": 1e-10, "balance": 1e-10, "moved (m)": 1e-10},
        cases.sphere_in_groove,
    ),
    Row(
        "box in a V groove, mu 0",
        "N = m g/(2 cos phi)",
        "-",
        {"N": 1e-10, "balance": 1e-10, "mirror": 1e-10, "moved (m)": 1e-10},
        cases.box_in_groove,
    ),
    Row(
        "box in a V groove, mu 0.3",
        "N = m g/(2 (cos phi + mu sin phi))",
        "everybody another",
        {"N": 1e-10, "balance": 1e-10, "mirror": 1e-10, "outside the cone": 1e-10},
        lambda s: cases.box_in_groove(s, 0.3),
    ),
    *(
        Row(
            f"spinning ball bounces, {law}",
            "Newton, Coulomb",
            "-",
            {"velocity": 1e-12, "spin": 1e-12},
            lambda s, law=law: cases.oblique_bounce(replace(s, impact_law=law)),
        )
        for law in ("sequential", "simultaneous", "reflections")
    ),
    *(
        Row(
            f"666 test, dt 10 ms{name}",
            "0",
            "9e-8 m² (PhysX), 1.3e-5 (Jolt)",
            {"squared penetration (m²)": 1e-10},
            lambda s, d=d: cases.heap_of_balls(s, stagger=d),
            FIXED,
        )
        for name, d in (("", 0.0), (", staggered", 0.02))
    ),
)


@dataclass
class Result:
    row: Row
    stepper: str
    figures: dict[str, float]
    seconds: float
    error: str = ""

    def short(self) -> list[str]:
        """Names of the figures that fall short."""
        if self.error:
            return ["error"]
        limits = self.row.limits(self.stepper)
        # `not <=` catches NaN as well.
        return [
            n for n, most in limits.items() if n in self.figures and not self.figures[n] <= most
        ]


def measure(
    rows=ROWS, steppers=BOTH, show: Callable[[str], None] = lambda _: None
) -> Iterator[Result]:
    """Runs the rows one after the other."""
    jobs = [(row, s) for row in rows for s in row.steppers if s in steppers]
    for n, (row, stepper) in enumerate(jobs, 1):
        show(f"[{n}/{len(jobs)}] {row.name} ({stepper})")
        begin = time.perf_counter()
        try:
            figures, error = row.run(Stage(stepper=stepper)), ""
        except Exception as problem:  # a row that breaks is a row that falls short
            figures, error = {}, f"{type(problem).__name__}: {problem}"
        yield Result(row, stepper, figures, time.perf_counter() - begin, error)


def lines_of(result: Result) -> Iterator[str]:
    """The table's lines of one result: one per judged figure."""
    row, short = result.row, result.short()
    if result.error:
        yield f"{row.name:<38}{result.stepper:<7}{result.error[:90]}  FALLS SHORT"
        return
    first = True
    limits = row.limits(result.stepper)
    named = set(row.targets) | set(row.event_targets or {})
    for name, most in limits.items():
        if name not in result.figures or (name not in named and name not in short):
            continue
        head = f"{row.name:<38}{result.stepper:<7}" if first else " " * 45
        tail = f"{row.exact:<36}{row.field}" if first else ""
        mark = "FALLS SHORT  " if name in short else " " * 13
        yield f"{head}{name:<26}{result.figures[name]:>9.1e}  <= {most:<8.0e}{mark}{tail}".rstrip()
        first = False


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", default="", help="only rows whose name contains this")
    parser.add_argument("--stepper", choices=BOTH, help="only this stepper (default: both)")
    parser.add_argument(
        "--plots",
        nargs="?",
        const="docs/images",
        metavar="FOLDER",
        help="also draw the cases (default folder: docs/images)",
    )
    chosen = parser.parse_args(arguments)
    rows = tuple(r for r in ROWS if chosen.rows.lower() in r.name.lower())
    if not rows:
        parser.error(f"no row contains {chosen.rows!r}; rows: {', '.join(r.name for r in ROWS)}")

    progress = sys.stderr.isatty()

    def show(text: str) -> None:
        print(
            f"\r\x1b[K{text}" if progress else text, end="" if progress else "\n", file=sys.stderr
        )

    head = f"{'case':<38}{'':<7}{'figure':<26}{'ours':>9}  {'target':<11}{'':<13}"
    print(head + f"{'exact answer':<36}best in the field", flush=True)
    results = []
    for result in measure(rows, (chosen.stepper,) if chosen.stepper else BOTH, show):
        if progress:
            print("\r\x1b[K", end="", file=sys.stderr)
        print("\n".join(lines_of(result)), flush=True)
        results.append(result)
    good = [r for r in results if not r.error]
    for name, most in (("residual", RESIDUAL), ("energy gain", ENERGY_GAIN)):
        worst = max(
            (r for r in good if name in r.figures), key=lambda r: r.figures[name], default=None
        )
        if worst:
            print(f"worst {name}: {worst.figures[name]:.1e} (<= {most:.0e}) in {worst.row.name}")
    short = [r for r in results if r.short()]
    print(
        f"{len(results) - len(short)} of {len(results)} reached, {sum(r.seconds for r in results):.0f} s"
    )
    for r in short:
        print(f"falls short: {r.row.name} ({r.stepper}): {', '.join(r.short())}")
    if chosen.plots:
        from .accuracy_plots import draw_all

        for path in draw_all(Path(chosen.plots)):
            print(f"drew {path}")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())
