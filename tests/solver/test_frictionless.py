"""Contacts without friction: 0 <= f, A f + d >= 0, f . (A f + d) = 0, found by pivoting."""

import itertools

import numpy as np
import pytest
from problems import GRAVITY, Builder, random_problem, tower

from rb_physics._core import solver


def heap_of_balls(rng: np.random.Generator, side: int) -> Builder:
    """Balls of different masses in a bed, each in touch with its neighbours, thrown about."""
    b = Builder()
    index = {}
    for cell in itertools.product(range(side), repeat=3):
        mass = 10 ** rng.uniform(-0.5, 0.5)
        place = 2.0 * np.array(cell) + rng.uniform(-0.1, 0.1, 3)
        velocity = rng.normal(size=3) + (0, 0, -GRAVITY)
        index[cell] = b.body(place, mass, np.eye(3) / (0.4 * mass), velocity)
    for cell, k in index.items():
        if cell[2] == 0:
            b.contact(k, -1, b.position[k] - (0, 0, 1), (0, 0, 1))
        for axis in range(3):
            near = tuple(c - (a == axis) for a, c in enumerate(cell))
            if near in index and rng.uniform() < 0.8:
                way = b.position[k] - b.position[index[near]]
                b.contact(k, index[near], b.position[k] - way / 2, way)
    return b


def normal_problem(b: Builder) -> tuple[np.ndarray, np.ndarray]:
    problem = b.problem()
    n, d = len(b.contacts), []
    for c in b.contacts:
        a, other = c["bodies"]
        u = b.velocity[a][:3] + np.cross(b.velocity[a][3:], c["r_a"])
        if other >= 0:
            u = u - b.velocity[other][:3] - np.cross(b.velocity[other][3:], c["r_b"])
        d.append(c["frame"][0] @ u)
    assert len(d) == n
    return solver.normal_delassus(problem), np.array(d)


@pytest.mark.parametrize("side", [1, 2, 3, 4])
def test_heaps_of_balls_meet_every_condition(side):
    rng = np.random.default_rng(side)
    for _ in range(20):
        b = heap_of_balls(rng, side)
        a, d = normal_problem(b)
        solution, report = solver.solve_contacts(b.problem())
        force = np.array(solution.impulse)[:, 0]
        speed = a @ force + d
        scale = np.abs(d).max()
        assert force.min() >= 0 and not np.array(solution.impulse)[:, 1:].any()
        # Rounding of sums over up to 6 neighbours, 1e-13 of the fastest approach.
        assert speed.min() >= -1e-13 * scale
        assert np.abs(speed[force > 0]).max(initial=0.0) <= 1e-13 * scale
        assert report.converged and report.residual <= 1e-13


def test_agrees_with_lemke_where_the_forces_are_unique():
    rng = np.random.default_rng(7)
    for _ in range(40):
        b = heap_of_balls(rng, 2)
        a, d = normal_problem(b)
        other = solver.lcp_lemke(a, d)
        assert other.solved
        solution, _ = solver.solve_contacts(b.problem())
        # Lemke's tableau rounds to 1e-11.
        force = np.array(solution.impulse)[:, 0]
        assert np.abs(force - other.z).max() <= 1e-11 * np.abs(other.z).max()


def test_redundant_corners_share_evenly():
    # A tower's corners depend on each other: least impulses, to the rounding of the solve.
    b = tower(3, dt=1.0, friction=0.0)
    solution, report = solver.solve_contacts(b.problem())
    share = np.array(solution.impulse)[:, 0].reshape(3, 4) / (
        GRAVITY * np.array([3.0, 2.0, 1.0])[:, None] / 4
    )
    assert np.abs(share - 1).max() <= 1e-11
    assert report.minimum_norm


def test_warm_start_is_taken_as_it_is():
    rng = np.random.default_rng(3)
    b = heap_of_balls(rng, 3)
    problem = b.problem()
    solution, _ = solver.solve_contacts(problem)
    before = np.array(solution.impulse).copy()
    again, report = solver.solve_contacts(problem, warm_start=solution)
    assert report.warm_accepted
    assert np.array_equal(np.array(again.impulse), before)


def test_random_heaps_without_friction():
    rng = np.random.default_rng(11)
    for _ in range(200):
        b = random_problem(rng, friction=0.0)
        problem = b.problem()
        solution, report = solver.solve_contacts(problem)
        assert report.residual <= 1e-8  # the ceiling of any island: masses over four decades
        assert np.array(solution.impulse)[:, 0].min() >= 0
