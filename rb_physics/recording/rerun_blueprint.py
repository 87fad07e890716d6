"""How the Rerun viewer arranges a recording when it is first opened."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import BodyDescription
from .palette import typical_radius


def overview(bodies: Sequence[BodyDescription], poses: NDArray, plotted: Sequence[str]) -> Any:
    """The scene at the left; energy, contact forces, solver and log at the right."""
    import rerun.blueprint as rrb

    legend = rrb.PlotLegend(corner=rrb.Corner2D.RightTop)
    scene = rrb.Spatial3DView(
        origin="/world",
        name="scene",
        eye_controls=_eye(bodies, poses),
        line_grid=rrb.LineGrid3D(visible=False),
        background=(248, 249, 251, 255),
    )
    plots = rrb.Vertical(
        rrb.TimeSeriesView(origin="/plots/energy", name="energy [J]", plot_legend=legend),
        rrb.TimeSeriesView(
            origin="/plots/contact_force", name="contact force on each body [N]", plot_legend=legend
        ),
        rrb.Tabs(
            rrb.TimeSeriesView(origin="/plots/solver", name="solver", plot_legend=legend),
            rrb.TextLogView(origin="/log", name="log"),
        ),
        row_shares=[1, 1, 0.8],
    )
    return rrb.Blueprint(
        rrb.Horizontal(scene, plots, column_shares=[3, 2]),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def _eye(bodies: Sequence[BodyDescription], poses: NDArray) -> Any:
    """Looks at the moving bodies from the front, right and above."""
    import rerun.blueprint as rrb

    moving = [row for row, body in enumerate(bodies) if body.type != "static"]
    margin = typical_radius(bodies)
    places = poses[moving, :3] if moving else np.zeros((1, 3))
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    low[2] = min(low[2], 0.0) if high[2] < 20 * margin + low[2] else low[2]
    target = (low + high) / 2
    distance = 1.25 * float(np.linalg.norm(high - low)) + 2 * margin
    direction = np.array([0.45, -1.0, 0.42])
    position = target + distance * direction / np.linalg.norm(direction)
    return rrb.EyeControls3D(position=position, look_target=target, eye_up=(0, 0, 1))
