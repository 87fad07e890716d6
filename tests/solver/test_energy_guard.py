"""Known paradoxes of impact with friction: no law gains energy, none hangs."""

import numpy as np
import pytest
from problems import Builder, box_inverse_inertia, cradle, kinetic_energy

from rb_physics._core import ImpactLaw, solver

LAWS = list(ImpactLaw.__members__.values())


def rod(angle_tangent, velocity, spin, friction, restitution):
    """Thin rod (length 2 m, 1 kg) whose lower end touches the floor at an angle."""
    c = 1 / np.sqrt(1 + angle_tangent**2)
    arm = -np.array([c, 0, angle_tangent * c])
    b = Builder()
    inertia = 1 / 3  # m (2 m)^2 / 12
    b.body(-arm, 1.0, np.diag([1 / inertia] * 3), velocity, (0, spin, 0))
    b.contact(0, -1, (0, 0, 0), (0, 0, 1), friction=friction, restitution=restitution)
    return b


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.5, 1.0])
@pytest.mark.parametrize("friction", [0.2, 0.7, 2.0])
@pytest.mark.parametrize("tangent", [0.3, 1.0, 2.5])
def test_kane_and_painleve_rods_lose_energy(law, restitution, friction, tangent):
    # Newton's law with Coulomb's friction gains energy here when the slip turns during the impact
    # (Kane 1984); Painleve's rod has no sliding solution at all for large friction.
    for velocity, spin in (((-3, 0, -1), 0.0), ((3, 0, -1), 0.0), ((-2, 0.5, 0), 2.0)):
        b = rod(tangent, velocity, spin, friction, restitution)
        arrays = b.arrays()
        solution, report = solver.apply_impact(b.problem(), law)
        # 1e-12 of its scale: rounding of a sum of a few products.
        assert report.conditions.worst() <= 1e-12
        before = kinetic_energy(arrays, arrays["velocity"])
        assert kinetic_energy(arrays, solution.velocity) <= before * (1 + 1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_three_balls_with_friction_lose_energy(law):
    b = cradle([1.0, 0.0, 0.0])
    b.velocity[0][3:] = (0, 0, 40.0)  # spinning fast: friction drives the others sideways
    for c in b.contacts:
        c["friction"] = 0.8
    arrays = b.arrays()
    solution, report = solver.apply_impact(b.problem(), law)
    before = kinetic_energy(arrays, arrays["velocity"])
    assert report.conditions.worst() <= 1e-12
    assert kinetic_energy(arrays, solution.velocity) <= before * (1 + 1e-12)
    momentum = solution.velocity[:, :3].sum(axis=0)
    assert np.abs(momentum - (1, 0, 0)).max() <= 1e-14  # rounding


@pytest.mark.parametrize("friction", [0.3, 1.0, 3.0])
def test_painleve_rod_in_sustained_contact_has_a_dissipative_answer(friction):
    # Sliding rod under gravity: the contact solve (a velocity-level problem) always has an answer.
    b = rod(2.0, (-3.0, 0, -0.01), 0.0, friction, 0.0)
    arrays = b.arrays()
    solution, report = solver.solve_contacts(b.problem())
    assert report.converged
    before = kinetic_energy(arrays, arrays["velocity"])
    assert kinetic_energy(arrays, solution.velocity) <= before * (1 + 1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_jammed_balls_with_restitution_end(law):
    # A ball driven into the gap between two walls that meet at a slim angle: impulses pass to and fro.
    b = Builder()
    b.body((0, 0, 0), 1.0, box_inverse_inertia(1.0, (0.1, 0.1, 0.1)), (0, -1, 0))
    for x in (-1, 1):
        b.contact(0, -1, (0, 0, 0), (x, 0.05, 0), restitution=0.9)
    _, report = solver.apply_impact(b.problem(), law)
    assert report.conditions.worst() <= 1e-12
