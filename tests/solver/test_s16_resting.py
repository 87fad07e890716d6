"""S16: resting contact, d_dd = A g + b with g >= 0, d_dd >= 0, g . d_dd = 0."""

import numpy as np
import pytest
from problems import GRAVITY, random_problem, tower

from rb_physics._core import solver

METHODS = list(solver.LcpMethod.__members__.values())


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [1, 3, 10])
def test_tower_rests_on_its_weight(method, count):
    b = tower(count, dt=1.0)  # accelerations: gravity itself
    force, acceleration, lcp = solver.resting_contact(b.problem(), method)
    weight_above = (count - np.arange(count)) * GRAVITY
    # Force sums to 1e-12 where the solver is refined; Lemke's tableau rounds to 1e-11.
    tolerance = 1e-12 if method == solver.LcpMethod.PIVOTING else 1e-11
    assert np.abs(force.reshape(count, 4).sum(axis=1) / weight_above - 1).max() <= tolerance
    assert np.abs(acceleration).max() <= 10 * count * GRAVITY * tolerance
    assert lcp.solved and lcp.residual <= tolerance


def test_pivoting_shares_redundant_corners_evenly():
    force, _, _ = solver.resting_contact(tower(2, dt=1.0).problem())
    # Least norm: four equal corners, to 1e-12, rounding of the solve.
    assert np.abs(force[:4] / (2 * GRAVITY / 4) - 1).max() <= 1e-12


def test_methods_agree_on_accelerations():
    rng = np.random.default_rng(16)
    for _ in range(150):
        b = random_problem(rng, friction=0.0)
        problem = b.problem()
        results = [solver.resting_contact(problem, m) for m in METHODS]
        a = solver.normal_delassus(problem)
        scale = np.abs(np.array(b.velocity)).max()
        for force, _, lcp in results:
            assert lcp.solved and lcp.residual <= 1e-9
            assert force.min() >= 0
        # Unique accelerations: agreement to 1e-10 times the condition of A on its range.
        s = np.linalg.eigvalsh(a)
        condition = s[-1] / s[s > 1e-10 * s[-1]][0]
        assert np.abs(results[0][1] - results[1][1]).max() <= 1e-10 * condition * scale


@pytest.mark.parametrize("solve", [solver.lcp_lemke, solver.lcp_pivoting])
def test_degenerate_problems_end(solve):
    # Ties in every ratio test: equal rows, zero entries in q.
    m = np.ones((6, 6)) + np.diag([1.0, 1, 0, 0, 0, 0])
    q = np.array([-1.0, -1, -1, -1, 0, 0])
    result = solve(m, q)
    assert result.solved and solver.lcp_residual(m, q, result.z) <= 1e-12


@pytest.mark.parametrize("solve", [solver.lcp_lemke, solver.lcp_pivoting])
def test_nothing_pushes_when_all_part(solve):
    result = solve(np.eye(3), np.array([0.0, 1, 2]))
    assert result.solved and not result.z.any()
