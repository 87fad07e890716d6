"""S12: several contacts one after the other: cheap, and dependent on the order."""

import numpy as np
from problems import cradle, tower, wedge

from rb_physics._core import ImpactLaw, solver

SEQUENTIAL = ImpactLaw.SEQUENTIAL


def test_order_decides_in_the_wedge():
    first, _ = solver.apply_impact(wedge(1.0, walls=(0, 1)).problem(), SEQUENTIAL)
    second, _ = solver.apply_impact(wedge(1.0, walls=(1, 0)).problem(), SEQUENTIAL)
    # (0, -1) off wall 0 is (1, 0), then off wall 1 (-0.6, 0.8). The other way round it is off wall 1
    # (-0.8, -0.6), off wall 0 (0.6, 0.8), off wall 1 again (0.28, 0.96). Exact but for rounding.
    assert np.abs(first.velocity[0, :2] - (-0.6, 0.8)).max() <= 1e-15 * 4
    assert np.abs(second.velocity[0, :2] - (0.28, 0.96)).max() <= 1e-15 * 4


def test_collisions_go_on_until_none_approaches():
    solution, report = solver.apply_impact(cradle([1, 0, 0, 0, 0]).problem(), SEQUENTIAL)
    assert np.abs(solution.velocity[:, 0] - (0, 0, 0, 0, 1)).max() <= 1e-15
    assert report.iterations >= 4 and not report.capped


def test_corners_of_a_dropped_box_all_part():
    b = tower(1)
    b.velocity[0][2] = -2.0
    for c in b.contacts:
        c["restitution"] = 0.5
    _, report = solver.apply_impact(b.problem(), SEQUENTIAL)
    assert report.residual <= 1e-12  # the four conditions, relative
