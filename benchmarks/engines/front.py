"""Penetration against time, one panel per scene: down and left is better."""

from __future__ import annotations

from pathlib import Path

from .runner import Cell
from .scenes import scenes

FLOOR = 1e-12  # m: what is less stands here


def draw(results: dict[str, list[Cell]], path: Path) -> None:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    columns = 4
    count = -(-len(results) // columns)
    figure, axes = plt.subplots(
        count, columns, figsize=(4 * columns, 3 * count), squeeze=False, layout="constrained"
    )
    engines = list(dict.fromkeys(cell.engine for cells in results.values() for cell in cells))
    colours = {name: f"C{k}" for k, name in enumerate(engines)}
    for panel in axes.flat[len(results) :]:
        panel.set_axis_off()
    for panel, (name, cells) in zip(axes.flat, results.items(), strict=False):
        panel.set_title(scenes()[name].name, fontsize=9)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_ylim(FLOOR / 3, 1e-1)
        for cell in cells:
            seconds = cell.seconds if cell.times else cell.at_least
            if not cell.depths or not seconds or not cell.finite:
                continue
            mark = "x" if cell.stands is False else "o" if cell.times else ">"
            panel.plot(
                1e3 * seconds, max(FLOOR, cell.depth(99)), mark, color=colours[cell.engine], ms=7
            )
    for panel in axes[:, 0]:
        panel.set_ylabel("penetration, 99 %, m", fontsize=8)
    for panel in axes[-1]:
        panel.set_xlabel("ms per step", fontsize=8)
    handles = [plt.Line2D([], [], ls="", marker="o", color=c, label=n) for n, c in colours.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle("Penetration against time per step; > was given up, × fell", fontsize=11)
    figure.savefig(path, dpi=80)
    plt.close(figure)
