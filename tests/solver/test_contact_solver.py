"""The staged contact solver on problems with a known answer."""

import numpy as np
import pytest
from problems import GRAVITY, tower

from rb_physics._core import solver

DT = 5e-3


@pytest.mark.parametrize("count", [1, 2, 10])
def test_tower_carries_its_weight_on_four_equal_corners(count):
    problem = tower(count, DT).problem()
    solution, report = solver.solve_contacts(problem)
    assert report.converged and report.minimum_norm
    # Direct islands end at rounding: 1e-13 of the typical velocity.
    assert solver.natural_map_residual(problem, solution) <= 1e-13
    weight_above = (count - np.arange(count)) * GRAVITY * DT
    normal = solution.impulse[:, 0].reshape(count, 4)
    # the accuracy table (make verify): force sums to 1e-12; corners share evenly to the same.
    assert np.abs(normal.sum(axis=1) / weight_above - 1).max() <= 1e-12
    assert np.abs(normal / (weight_above[:, None] / 4) - 1).max() <= 1e-12
    assert np.abs(solution.velocity).max() <= 1e-13 * count * GRAVITY * DT


def test_settled_warm_start_is_accepted_unchanged():
    problem = tower(10, DT).problem()
    first, _ = solver.solve_contacts(problem)
    second, report = solver.solve_contacts(problem, first)
    assert report.warm_accepted and report.newton_steps == 0 and report.sweeps == 0
    assert np.array_equal(first.impulse, second.impulse)


def test_warm_start_that_balances_but_is_not_the_least_is_solved_again():
    problem = tower(1, DT).problem()
    first, _ = solver.solve_contacts(problem)
    twisted = first.impulse.copy()
    # Self-stress of four corners: changes no motion, so the residual cannot see it.
    twisted[:, 0] += 1e-3 * np.array([1, -1, -1, 1])
    start = solver.ContactSolution(twisted)
    assert solver.natural_map_residual(problem, start) <= 1e-13  # rounding of the sums
    second, report = solver.solve_contacts(problem, start)
    assert not report.warm_accepted
    assert np.abs(second.impulse - first.impulse).max() <= 1e-14  # rounding of 0.0123 N s


def test_work_bound_is_reported():
    settings = solver.SolverSettings()
    settings.max_work = 50
    _, report = solver.solve_contacts(tower(10, DT).problem(), settings=settings)
    assert report.work_exhausted and not report.converged and report.residual > 1e-13


def test_bad_contact_is_named():
    arrays = tower(1, DT).arrays()
    arrays["friction"][2] = -0.1
    with pytest.raises(ValueError, match="contact 2: friction"):
        solver.ContactProblem(**arrays)


@pytest.mark.parametrize("count", [10, 30])
@pytest.mark.parametrize("case", ["struck", "sliding", "stirred"])
def test_tower_in_motion_meets_the_residual(count, case):
    # The weak spot of the fixed point on De Saxce's term: many contacts sliding at once.
    b = tower(count, DT)
    for i, v in enumerate(b.velocity):
        if case == "struck":
            v[:2] += (3.0, 0.4) if i == count // 2 else (0.0, 0.0)
        elif case == "sliding":
            v[0] += 1.0
        else:
            v[:2] += 0.1 * ((7 * i) % 5 - 2), 0.1 * ((3 * i) % 5 - 2)
            v[5] += 0.3 * ((2 * i) % 3 - 1)
    problem = b.problem()
    solution, _ = solver.solve_contacts(problem)
    # Ten boxes end at rounding; thirty are ill-conditioned and keep well below the 1e-8 ceiling.
    assert solver.natural_map_residual(problem, solution) <= (1e-12 if count == 10 else 1e-9)


def test_tower_of_thirty_shares_evenly():
    problem = tower(30, DT).problem()
    solution, report = solver.solve_contacts(problem)
    normal = solution.impulse[:, 0].reshape(30, 4)
    weight_above = (30 - np.arange(30)) * GRAVITY * DT
    assert report.minimum_norm
    # A slender stack amplifies rounding by about count^4 = 1e6 in its bending.
    assert np.abs(normal / (weight_above[:, None] / 4) - 1).max() <= 1e-10
