"""A quick picture of a recording: energy, contact forces, heights."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .compare import UNITS, differences
from .errors import RecordingError
from .new_path import new_file, writing
from .tables import Tables, read_tables

_MOST = 12  # bodies drawn


def plot(recording: str | Path, png: str | Path) -> Path:
    """Draws into a new PNG file. Needs matplotlib. Raises RecordingError."""
    pyplot = _pyplot()
    png = new_file(png)
    tables = read_tables(recording)
    figure, axes = pyplot.subplots(3, 1, sharex=True, figsize=(9, 9), layout="constrained")
    totals = tables.totals
    if len(totals):
        time = np.maximum.accumulate(totals["time"])
        axes[0].plot(time, totals["kinetic_energy"], label="kinetic")
        axes[0].plot(time, totals["potential_energy"], label="potential")
        axes[0].plot(time, totals["kinetic_energy"] + totals["potential_energy"], label="total")
    _per_body(axes[1], tables, _measured(tables), "force")
    _per_body(axes[2], tables, tables.poses, "position")
    for axis, label in zip(axes, ("energy [J]", "contact force [N]", "height [m]"), strict=True):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
        if axis.lines:
            axis.legend(loc="upper right", fontsize="small", ncols=2)
    axes[2].set_xlabel("time [s]")
    axes[0].set_title(Path(recording).name)
    with writing(png):
        figure.savefig(png, dpi=120)
    pyplot.close(figure)
    return png


def plot_comparison(first: str | Path, second: str | Path, png: str | Path) -> Path:
    """Draws how far bodies of two recordings are apart, farthest first: positions, orientations,
    and velocities where both logged them. Raises RecordingError."""
    pyplot = _pyplot()
    png = new_file(png)
    bodies = differences(first, second)
    drawn = [quantity for quantity in UNITS if any(quantity in of for of in bodies.values())]
    if not drawn:
        raise RecordingError(f"{first} and {second} have no poses of one body at one time")
    size = (9, 1 + 3 * len(drawn))
    figure, axes = pyplot.subplots(len(drawn), 1, sharex=True, figsize=size, layout="constrained")
    for axis, quantity in zip(axes, drawn, strict=True):
        apart = {n: of[quantity] for n, of in bodies.items() if quantity in of}
        apart = {n: series for n, series in apart.items() if series.differs.any()}
        for name, series in sorted(apart.items(), key=lambda e: -e[1].apart.max())[:_MOST]:
            # Zero has no logarithm: the curve is interrupted there; a dot shows a moment alone.
            values = np.where(series.apart > 0, series.apart, np.nan)
            axis.semilogy(series.time, values, marker=".", markersize=2, label=name)
        axis.set_ylabel(f"{quantity} apart [{UNITS[quantity]}]")
        axis.grid(alpha=0.3)
        if apart:
            axis.legend(loc="lower right", fontsize="small", ncols=2)
        else:
            axis.text(0.5, 0.5, "no difference", transform=axis.transAxes, ha="center")
    axes[-1].set_xlabel("time [s]")
    axes[0].set_title(f"{Path(first).name} and {Path(second).name}")
    with writing(png):
        figure.savefig(png, dpi=120)
    pyplot.close(figure)
    return png


def _measured(tables: Tables) -> np.ndarray:
    """The first wrench topic of each body, behind the start, which is a mean of no time at all."""
    wrenches = tables.wrenches
    if not len(wrenches):
        return wrenches
    _, at, body = np.unique(wrenches["body"], return_index=True, return_inverse=True)
    first = wrenches["topic"][at][body] == wrenches["topic"]
    measured: np.ndarray = wrenches[first & (wrenches["time"] > wrenches["time"].min())]
    return measured


def _per_body(axis: Any, tables: Tables, table: np.ndarray, field: str) -> None:
    for body in np.unique(table["body"])[:_MOST]:
        rows = table[table["body"] == body]
        values = rows[field]
        drawn = values[:, 2] if field == "position" else np.linalg.norm(values, axis=1)
        if field == "position" and not np.ptp(rows["position"]) and len(rows) > 1:
            continue  # does not move
        axis.plot(rows["time"], drawn, label=tables.bodies[body])


def _pyplot() -> Any:
    try:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot
    except ImportError:
        raise RecordingError("plots need the matplotlib package: pip install matplotlib") from None
    return pyplot
