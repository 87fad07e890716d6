"""S13: the notes' wedge, all numbers."""

import numpy as np
import pytest
from problems import wedge

from rb_physics._core import ImpactLaw, solver

NORMALS = np.array([[1, 1] / np.sqrt(2), [-2, 1] / np.sqrt(5)])
LAM = 1.7


def after(law=ImpactLaw.SIMULTANEOUS, **kwargs):
    return solver.apply_impact(wedge(LAM, **kwargs).problem(), law)[0].velocity[0, :2]


def test_one_wall_alone_leaves_the_other_blocked():
    alone = [after(walls=(0,)), after(walls=(1,))]
    # Rounding of numbers of order one.
    assert np.abs(alone[0] - np.array([1, 0]) * LAM).max() <= 1e-15 * 4
    assert np.abs(alone[1] - np.array([-0.8, -0.6]) * LAM).max() <= 1e-15 * 4
    average = (alone[0] + alone[1]) / 2
    assert np.abs(average - np.array([0.1, -0.3]) * LAM).max() <= 1e-15 * 4
    assert NORMALS[1] @ alone[0] < 0 and NORMALS[0] @ alone[1] < 0
    assert (NORMALS @ average < 0).all()


def test_simultaneous_answer_sends_the_particle_back():
    # A direct island ends at 1e-13 of its typical velocity (tolerance::direct_residual).
    assert np.abs(after() - (0, LAM)).max() <= 1e-13 * LAM


@pytest.mark.parametrize("restitution", [0.0, 0.25, 0.8])
def test_restitution_scales_the_answer(restitution):
    assert np.abs(after(restitution=restitution) - (0, restitution * LAM)).max() <= 1e-13 * LAM


def test_order_of_the_walls_does_not_matter():
    assert np.abs(after(walls=(1, 0)) - after(walls=(0, 1))).max() <= 1e-13 * LAM
