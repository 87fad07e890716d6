"""S11: one contact, closed form, both bodies."""

import numpy as np
import pytest
from problems import Builder, box_inverse_inertia

from rb_physics._core import ImpactLaw, solver

LAWS = list(ImpactLaw.__members__.values())


def two_boxes(restitution, friction=0.0):
    b = Builder()
    b.body((0, 0, 0.2), 2.0, box_inverse_inertia(2.0, (0.1, 0.2, 0.1)), (0.3, 0.1, -1), (1, 2, 3))
    b.body((0.02, 0, 0), 5.0, box_inverse_inertia(5.0, (0.3, 0.2, 0.1)), (0, 0.2, 0.4), (0, -1, 1))
    b.contact(0, 1, (0.05, 0.1, 0.1), (0, 0, 1), restitution=restitution, friction=friction)
    return b


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
def test_normal_speed_is_reversed_and_scaled(law, restitution):
    b = two_boxes(restitution)
    c, v = b.contacts[0], np.array(b.velocity)

    def slip(v):
        return v[0, :3] + np.cross(v[0, 3:], c["r_a"]) - v[1, :3] - np.cross(v[1, 3:], c["r_b"])

    n = np.array([0, 0, 1])
    # f = -(1 + e) (N.v-) / (1/mA + 1/mB + (rA x N).J_A^-1 (rA x N) + the same for B), the notes' S11.
    a = sum(b.inv_mass)
    for k, r in ((0, c["r_a"]), (1, c["r_b"])):
        a += np.cross(r, n) @ b.inv_inertia[k] @ np.cross(r, n)
    f = -(1 + restitution) * (n @ slip(v)) / a
    solution, report = solver.apply_impact(b.problem(), law)
    # Closed form against closed form: rounding.
    assert abs(solution.impulse[0, 0] / f - 1) <= 1e-14
    assert abs(n @ slip(solution.velocity) + restitution * (n @ slip(v))) <= 1e-14
    assert report.residual <= 1e-14
    p = np.array(b.inv_mass)[:, None]
    momentum = (v[:, :3] / p).sum(axis=0) - (solution.velocity[:, :3] / p).sum(axis=0)
    assert np.abs(momentum).max() <= 1e-14 * 10  # rounding of momenta of up to 10 N s


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("friction", [0.05, 0.2, 0.6, 2.0])
def test_spinning_ball_bounces_off_a_rough_floor(law, friction):
    radius, mass, restitution = 0.13, 0.7, 0.6
    b = Builder()
    b.body((0, 0, radius), mass, np.eye(3) / (0.4 * mass * radius**2), (1, -0.4, -2), (3, 5, 7))
    b.contact(0, -1, (0, 0, 0), (0, 0, 1), friction=friction, restitution=restitution)
    v, w = b.velocity[0][:3], b.velocity[0][3:]
    arm = np.array([0, 0, -radius])
    u = (v + np.cross(w, arm)) * (1, 1, 0)
    size = np.linalg.norm(u)
    change = -u / size * min(friction * (1 + restitution) * abs(v[2]), 2 * size / 7)
    spin = np.cross(arm, mass * change) / (0.4 * mass * radius**2)
    solution, _ = solver.apply_impact(b.problem(), law)
    # 1e-12 of the speeds (order one) and spins (order ten).
    assert np.abs(solution.velocity[0, :2] - v[:2] - change[:2]).max() <= 1e-12
    assert np.abs(solution.velocity[0, 3:] - w - spin).max() <= 1e-11
    assert abs(solution.velocity[0, 2] - restitution * 2) <= 1e-13


def test_parting_contact_is_left_alone():
    b = two_boxes(0.5)
    b.velocity[0][2] = 3.0
    solution, _ = solver.apply_impact(b.problem(), LAWS[0])
    assert np.array_equal(solution.velocity, np.array(b.velocity))
    assert not solution.impulse.any()
