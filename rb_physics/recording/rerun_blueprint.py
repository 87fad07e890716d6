"""How the Rerun viewer arranges a recording when it is first opened."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription
from .palette import ForceArrows, typical_radius

BLUEPRINTS = ("overview", "contact", "debug")
_TRAIL = 1.0  # s of trajectory behind each body


def blueprint(
    name: str, bodies: Sequence[BodyDescription], poses: NDArray, arrows: ForceArrows
) -> Any:
    """overview: scene, energy, forces. contact: the scene large, forces and log. debug: all plots."""
    import rerun.blueprint as rrb

    scene = rrb.Spatial3DView(
        origin="/world",
        name=_scene_name(arrows, all(body.friction is not None for body in bodies)),
        eye_controls=_eye(bodies, poses, 0.8 if name == "contact" else 1.25),
        line_grid=rrb.LineGrid3D(visible=False),
        background=(248, 249, 251, 255),
        overrides={"/world/trajectories": _trail()},
    )
    energy, forces = _plot("energy", "energy [J]"), _plot("contact_force", "contact force [N]")
    solver = _plot("solver", "solver")
    log = rrb.TextLogView(origin="/log", name="log")
    content: Any
    if name == "overview":
        plots = rrb.Vertical(energy, forces, rrb.Tabs(solver, log), row_shares=[1, 1, 0.8])
        content = rrb.Horizontal(scene, plots, column_shares=[3, 2])
    elif name == "contact":
        below = rrb.Horizontal(forces, _plot("contacts", "contact points"), log)
        content = rrb.Vertical(scene, below, row_shares=[5, 2])
    elif name == "debug":
        grid = rrb.Grid(
            energy, forces, _plot("momentum", "momentum"), solver,
            _plot("contacts", "contact points"), log, grid_columns=2,
        )  # fmt: skip
        content = rrb.Horizontal(scene, grid, column_shares=[2, 3])
    else:
        raise ValueError(f"blueprint {name!r} is not one of {', '.join(BLUEPRINTS)}")
    return rrb.Blueprint(
        content,
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def _scene_name(arrows: ForceArrows, colored: bool) -> str:
    """With what can't be read off the arrows: their scale, and what their colours mean."""
    text = f"forces: 1 m = {1 / arrows.scale:.3g} N, log above {arrows.knee:.3g} N"
    return text + ("; teal to red: friction used" if colored else "")


def _plot(entity: str, name: str) -> Any:
    import rerun.blueprint as rrb

    legend = rrb.PlotLegend(corner=rrb.Corner2D.RightTop)
    return rrb.TimeSeriesView(origin=f"/plots/{entity}", name=name, plot_legend=legend)


def _trail() -> Any:
    import rerun.blueprint as rrb

    return rrb.VisibleTimeRanges(
        timeline="sim_time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-_TRAIL),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )


def _eye(bodies: Sequence[BodyDescription], poses: NDArray, away: float) -> Any:
    """Looks at the moving bodies from the front, right and above, `away` times their extent."""
    import rerun.blueprint as rrb

    moving = [row for row, body in enumerate(bodies) if body.type != "static"]
    margin = typical_radius(bodies)
    places = poses[moving, :3] if moving else np.zeros((1, 3))
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    low[2] = min(low[2], 0.0) if high[2] < 20 * margin + low[2] else low[2]
    target = (low + high) / 2
    distance = away * float(np.linalg.norm(high - low)) + 2 * margin
    direction = np.array([0.45, -1.0, 0.42])
    position = target + distance * direction / np.linalg.norm(direction)
    return rrb.EyeControls3D(position=position, look_target=target, eye_up=(0, 0, 1))
