"""The table, with ratios to rb_physics."""

from __future__ import annotations

import os
import platform
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from .runner import Cell
from .scenes import scenes

US = "rb_physics"


def model_name() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.machine()


def milliseconds(seconds: float) -> str:
    ms = 1e3 * seconds
    return f"{ms:.4f}" if ms < 0.1 else f"{ms:.3g}" if ms < 1000 else f"{ms:.0f}"


def length(metres: float) -> str:
    if metres == 0:
        return "0"
    return f"{1e3 * metres:.2g} mm" if metres >= 1e-5 else f"{metres:.0e} m"


def time_of(cell: Cell) -> str:
    if cell.times:
        short = (
            ""
            if len(cell.times) == cell.planned
            else f" ({len(cell.times)} of {cell.planned} blocks)"
        )
        return milliseconds(cell.seconds) + short
    if cell.at_least:
        return f"> {milliseconds(cell.at_least)}"
    return "–"


def ratio(cell: Cell, ours: Cell | None) -> str:
    """Their time over ours: above 1 we are faster."""
    if ours is None or cell.engine == US:
        return ""
    theirs, us = cell.seconds, ours.seconds
    if cell.times and ours.times:
        return f"{theirs / us:.2g}"
    if cell.times and ours.at_least:
        return f"< {theirs / ours.at_least:.2g}"
    if cell.at_least and ours.times:
        return f"> {cell.at_least / us:.2g}"
    return ""


def rows(name: str, cells: list[Cell], labels: dict[str, str]) -> list[str]:
    scene = scenes()[name]
    ours = next((c for c in cells if c.engine == US), None)
    lines = []
    for cell in cells:
        note = cell.bad
        if cell.stands is False:
            note = "fell"
        if scene.squared and cell.depths:
            note = (note + "; " if note else "") + f"squared penetration {cell.squared:.1e} m²"
        depths = ("–", "–")
        if cell.depths and cell.finite:
            depths = (length(cell.depth(99)), length(cell.depth(100)))
        lines.append(
            f"| {scene.name} | {labels.get(cell.engine, cell.engine)} | {time_of(cell)} | "
            f"{ratio(cell, ours)} | {depths[0]} | {depths[1]} | {note} |"
        )
    return lines


HEADER = [
    "| scene | engine | ms per step | time / ours | penetration, 99 % | largest | |",
    "|---|---|---|---|---|---|---|",
]


def document(
    results: dict[str, list[Cell]], labels: dict[str, str], missing: dict[str, str], cap: float
) -> str:
    today = datetime.now(UTC).strftime("%Y-%m-%d")
    lines = [
        "# rb_physics beside other engines",
        "",
        "Written by `make bench-engines`; edit nothing here.",
        "",
        f"Measured {today} on {model_name()}, {os.cpu_count()} cores, {platform.system()} "
        f"{platform.machine()}, Python {platform.python_version()}, NumPy {np.__version__}. One core, "
        "one thread; blocks of steps of all engines take turns; medians over blocks. Sleeping, damping "
        "and continuous collision off, all else at each engine's defaults. Penetration is computed from "
        "poses alone, over all pairs closer than 1 mm. `>`: given up; every engine had "
        f"{cap:g} s per scene for its steps. A ratio above 1 means that rb_physics is faster.",
        "",
        "![Penetration against time](results.png)",
        "",
        "| engine | version | precision |",
        "|---|---|---|",
        *(f"| {name} | {label} |" for name, label in labels.items()),
        "",
    ]
    if missing:
        lines += ["Not here: " + "; ".join(f"{n} ({why})" for n, why in missing.items()) + ".", ""]
    lines += HEADER
    for name, cells in results.items():
        lines += rows(name, cells, {})
    return "\n".join(lines) + "\n"
