"""S14: repulsive, no interpenetration, no gain of energy: checked on every law and problem."""

import numpy as np
import pytest
from problems import billiard_rack, cradle, kinetic_energy, random_problem
from scipy.optimize import minimize

from rb_physics._core import ImpactLaw, solver

LAW = ImpactLaw
LAWS = list(LAW.__members__.values())


@pytest.mark.parametrize("law", LAWS)
def test_random_impacts_meet_all_conditions(law):
    rng = np.random.default_rng(14)
    for k in range(60):
        b = random_problem(rng)
        epsilon = rng.uniform()
        for c in b.contacts:
            c["restitution"] = epsilon if k % 2 else rng.uniform()
        arrays = b.arrays()
        solution, report = solver.apply_impact(b.problem(), law)
        # energy to 1e-12 of its scale; the same for the rest, relative.
        assert report.conditions.worst() <= 1e-12, (k, report.conditions.worst())
        before = kinetic_energy(arrays, arrays["velocity"])
        assert kinetic_energy(arrays, solution.velocity) <= before * (1 + 1e-12)


def test_simultaneous_is_the_constrained_minimum():
    # Oracle: scipy's SLSQP on minimise |A f + b|^2 under the notes' conditions.
    rng = np.random.default_rng(41)
    for _ in range(10):
        b = random_problem(rng, friction=0.0)
        while not 2 <= len(b.contacts) <= 6:
            b = random_problem(rng, friction=0.0)
        for c in b.contacts:
            c["restitution"] = 0.8
        problem = b.problem()
        a = solver.normal_delassus(problem)
        v = np.array(b.velocity)
        d = np.array([slip(c, v) for c in b.contacts])
        if d.min() >= 0:
            continue
        aim = np.where(d < 0, 1.8 * d, 0.0)
        scale_a, scale_d = np.trace(a) / len(d), np.abs(d).max()
        a, d, aim = a / scale_a, d / scale_d, aim / scale_d
        solution, _ = solver.apply_impact(problem, LAW.SIMULTANEOUS)
        f = solution.impulse[:, 0] * scale_a / scale_d
        ours = ((a @ f + aim) ** 2).sum()
        best = slsqp_minimum(a, aim, d, f)
        # SLSQP's own accuracy; its answers may violate constraints by as much.
        assert ours <= best + 1e-6


def slsqp_minimum(a, aim, d, start):
    return minimize(
        lambda f: ((a @ f + aim) ** 2).sum(),
        np.maximum(start + 0.01, 0),
        jac=lambda f: 2 * a @ (a @ f + aim),
        bounds=[(0, None)] * len(d),
        constraints=[
            {"type": "ineq", "fun": lambda f: a @ f + d, "jac": lambda f: a},
            {"type": "ineq", "fun": lambda f: -f @ (a @ f + 2 * d)},
        ],
        options={"ftol": 1e-14, "maxiter": 500},
    ).fun


def slip(c, v):
    a, b = c["bodies"]
    u = v[a, :3] + np.cross(v[a, 3:], c["r_a"])
    if b >= 0:
        u = u - v[b, :3] - np.cross(v[b, 3:], c["r_b"])
    return c["frame"][0] @ u


def test_cradle_of_five():
    v = [1, 0, 0, 0, 0]
    out = {law: solver.apply_impact(cradle(v).problem(), law)[0].velocity[:, 0] for law in LAWS}
    # the accuracy table (make verify): reflections to 1e-12; simultaneous keeps energy, not the motion.
    assert np.abs(out[LAW.REFLECTIONS] - (0, 0, 0, 0, 1)).max() <= 1e-12
    assert np.abs(out[LAW.SIMULTANEOUS] - (-0.6, 0.4, 0.4, 0.4, 0.4)).max() <= 1e-12


@pytest.mark.parametrize("struck", [1, 2, 3, 4])
def test_cradle_sends_out_as_many_as_came_in(struck):
    v = [1.0] * struck + [0.0] * (5 - struck)
    solution, _ = solver.apply_impact(cradle(v).problem(), LAW.REFLECTIONS)
    assert np.abs(solution.velocity[:, 0] - v[::-1]).max() <= 1e-12


def test_blend_with_the_inelastic_answer():
    solution, _ = solver.apply_impact(cradle([1, 0, 0, 0, 0], 0.5).problem(), LAW.REFLECTIONS)
    # Half of (0, 0, 0, 0, 1), half of all together at 1/5.
    assert np.abs(solution.velocity[:, 0] - (0.1, 0.1, 0.1, 0.1, 0.6)).max() <= 1e-12


@pytest.mark.parametrize("law", [LAW.SIMULTANEOUS, LAW.REFLECTIONS])
@pytest.mark.parametrize("rows", [2, 3, 5])
def test_billiard_break_is_symmetric(law, rows):
    b = billiard_rack(rows, 1.0)
    solution, report = solver.apply_impact(b.problem(), law)
    velocity = solution.velocity
    mirror = {tuple(np.round(p * (1, -1, 1), 9) + 0.0): k for k, p in enumerate(b.position)}
    for k, p in enumerate(b.position):
        other = velocity[mirror[tuple(np.round(p, 9) + 0.0)]]
        # symmetric to 1e-12 of the cue ball's speed.
        assert np.abs(velocity[k, :2] - other[:2] * (1, -1)).max() <= 1e-12
    assert report.conditions.worst() <= 1e-12
    momentum = velocity[:, :3].sum(axis=0)
    assert np.abs(momentum - (1, 0, 0)).max() <= 1e-12


def test_moving_wall_does_no_more_than_its_work():
    b = cradle([0.0])
    b.contact(0, -1, (-0.1, 0, 0), (1, 0, 0), restitution=1.0, bias=(-2.0, 0, 0))
    for law in LAWS:
        solution, report = solver.apply_impact(b.problem(), law)
        # A wall coming at 2 m/s throws the ball at 4 m/s; in its frame no energy is gained.
        assert abs(solution.velocity[0, 0] - 4.0) <= 1e-14
        assert report.energy_gain <= 1e-12
