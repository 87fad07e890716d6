"""Large islands: coloured wide sweeps solve Coulomb's law, with the same bits from every instruction
set and any number of threads."""

import numpy as np
import pytest
from problems import Builder, box_inverse_inertia

import rb_physics as rb
from rb_physics._core import solver

E = 0.1


@pytest.fixture
def level():
    """Puts the level back that was in use."""
    before = solver.simd_level()
    yield solver.choose_simd_level
    solver.choose_simd_level(before)


def wall(columns: int, rows: int, friction: float = 0.5) -> Builder:
    """Bricks in running bond on a floor, pushed about by random velocities (m/s, rad/s)."""
    random = np.random.default_rng(3)
    b = Builder()
    number = {}
    for row in range(rows):
        for column in range(columns):
            x = 2 * E * column + E * (row % 2)
            number[row, column] = b.body(
                (x, 0, E + 2 * E * row),
                1.0 + column % 3,
                box_inverse_inertia(1.0 + column % 3, (E, E, E)),
                linear=random.uniform(-0.05, 0.05, 3) - (0, 0, 0.05),
                angular=random.uniform(-0.3, 0.3, 3),
            )
    for (row, column), a in number.items():
        x, z = 2 * E * column + E * (row % 2), 2 * E * row
        below = [number.get((row - 1, column + k - 1 + row % 2)) for k in range(2)]
        for half in range(2):
            other = -1 if row == 0 else below[half]
            if other is None:
                continue
            for px in (x + E * (half - 1), x + E * half):
                for py in (-E, E):
                    b.contact(a, other, (px, py, z), (0, 0, 1), friction=friction)
    return b


def iterated(sweeps: int) -> solver.SolverSettings:
    settings = solver.SolverSettings()
    settings.max_factor_work = 0.0  # nothing is factorised
    settings.max_sweeps = sweeps
    return settings


@pytest.mark.parametrize("friction", [0.0, 0.5, 1.0])
def test_sweeps_converge_to_coulombs_law(friction):
    problem = wall(8, 6, friction).problem()
    solution, report = solver.solve_contacts(problem, settings=iterated(4000))
    # Accelerated sweeps gain a digit in some hundred; friction may end them in a small limit cycle.
    assert report.residual < (1e-8 if friction == 0.0 else 1e-5)
    judged = solver.natural_map_residual(problem, solution)
    assert judged == pytest.approx(report.residual, rel=1e-3, abs=1e-14)


def test_the_direct_solver_finds_the_same_velocities():
    problem = wall(5, 4, 0.0).problem()
    swept, _ = solver.solve_contacts(problem, settings=iterated(4000))
    direct, report = solver.solve_contacts(problem)
    assert report.factorizations > 0
    # Without friction velocities are unique; both are solved to 1e-9 of some 0.1 m/s.
    np.testing.assert_allclose(swept.velocity, direct.velocity, atol=1e-7)


def test_impulses_and_velocities_belong_together():
    builder = wall(8, 6)
    solution, _ = solver.solve_contacts(builder.problem(), settings=iterated(30))
    arrays = builder.arrays()
    momentum = solution.velocity[:, :3] - arrays["velocity"][:, :3]
    momentum /= arrays["inv_mass"][:, None]
    want = np.zeros_like(momentum)
    force = np.einsum("cij,ci->cj", arrays["frame"], solution.impulse)
    np.add.at(want, arrays["bodies"][:, 0], force)
    inner = arrays["bodies"][:, 1] >= 0
    np.subtract.at(want, arrays["bodies"][inner, 1], force[inner])
    np.testing.assert_allclose(momentum, want, atol=1e-14)  # sums of some 30 numbers below 1
    limit = 0.5 * solution.impulse[:, 0]
    assert (solution.impulse[:, 0] >= 0).all()
    # In the cone to rounding: a restarted sweep ends every solve.
    assert (np.linalg.norm(solution.impulse[:, 1:], axis=1) <= limit * (1 + 1e-14) + 1e-16).all()


def test_every_level_of_this_machine_gives_the_same_bits(level, capsys):
    problem = wall(8, 6).problem()
    answers = {}
    for name, available in solver.simd_levels().items():
        if not available:
            with capsys.disabled():
                print(f"\nSIMD level not run, this machine has none: {name}")
            with pytest.raises(ValueError, match=name):
                level(name)
            continue
        level(name)
        assert solver.simd_level() == name
        solution, report = solver.solve_contacts(problem, settings=iterated(60))
        answers[name] = (solution.impulse.tobytes(), solution.velocity.tobytes(), report.residual)
    assert "base" in answers
    assert all(answer == answers["base"] for answer in answers.values())


def test_an_unknown_level_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match="'mmx'.*base"):
        solver.choose_simd_level("mmx")


def pile(threads: int = 1, **settings) -> rb.World:
    """Layers of 7 x 7 and 6 x 6 boxes a little astray: about 2000 contact points in one island."""
    random = np.random.default_rng(7)
    world = rb.World(dt=5e-3, threads=threads, **settings)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static")
    for layer in range(4):
        side = 7 - layer % 2
        for row in range(side):
            for column in range(side):
                shift = E * (layer % 2)
                astray = random.uniform(-2e-4, 2e-4, 2)
                x = (0.202 * column + shift + astray[0], 0.202 * row + shift + astray[1])
                world.add_body(
                    rb.Box((E, E, E)), mass=1.0, position=(*x, E + 0.2005 * layer), friction=0.5
                )
    return world


def hashes(world: rb.World, steps: int = 30) -> list[int]:
    out = []
    for n in range(steps):
        if n == 20:
            world.bodies[40].apply_wrench((300, 20, 0), (0, 0, 0), duration=0.02)
        world.step()
        out.append(world.state_hash)
    return out


def test_a_pile_has_the_same_bits_at_every_level(level):
    names = [name for name, available in solver.simd_levels().items() if available]
    runs = []
    for name in names:
        level(name)
        runs.append(hashes(pile()))
    assert all(run == runs[0] for run in runs)


def test_a_pile_has_the_same_bits_with_any_number_of_threads():
    want = hashes(pile())
    assert hashes(pile(threads=2)) == want
    assert hashes(pile(threads=4)) == want


def test_a_pile_rests_without_overlap_and_carries_its_weight():
    world = pile()
    world.step(200)
    for _ in range(10):
        world.step()
        assert world.stats.max_penetration < 1e-6  # m; engines leave a tenth to several mm
        assert world.stats.residual < 1e-4  # 1e-6 reached; a corner may slip now and then
        assert world.stats.energy_error == 0.0
    floor = world.contacts[world.contacts["body_b"] == 0]
    weight = (len(world.bodies) - 1) * 9.81
    assert floor["force"][:, 2].sum() == pytest.approx(weight, rel=1e-5)  # as the residual
    speed = np.linalg.norm(world.linear_velocities, axis=1)
    assert speed.max() < 1e-4  # m/s; 1e-7 to 1e-6 reached


def test_a_pile_thrown_down_loses_energy_and_does_not_sink_in():
    world = pile()
    for body in world.bodies[1:]:
        body.linear_velocity = (0, 0, -0.5)
    world.step(40)
    assert world.stats.max_penetration < 1e-5  # m, while it still moves
    assert world.kinetic_energy < 0.5 * (len(world.bodies) - 1) * 0.5**2
