"""S11: one contact, both bodies: v+ = N_perp - eps (N . v-) N at the contact, f in closed form."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import multiply, rotation, turn

LAWS = ("sequential", "simultaneous", "reflections")


def velocity_at(body, point):
    return body.linear_velocity + np.cross(body.angular_velocity, point - body.com_position)


def inverse_inertia(body):
    R = rotation(body.orientation)
    return R @ np.linalg.inv(body.inertia) @ R.T


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("restitution", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("mass_ratio", [1.0, 1e-4, 1e4])
def test_two_spinning_boxes_meet_edge_to_edge(law, stepper, restitution, mass_ratio):
    """Frictionless, off-centre: f = -(1 + eps) d_dot / a along N, nothing across it."""
    # So short that what follows the impact (contact forces of edges that stay in touch) does not show.
    world = rb.World(gravity=(0, 0, 0), dt=1e-13, impact_law=law, stepper=stepper)
    half = np.array([0.1, 0.5, 0.1])
    on_edge = turn((0, 1, 0), np.pi / 4)
    low = world.add_body(
        rb.Box(half), mass=2.0, orientation=on_edge, friction=0.0, restitution=restitution
    )
    high = world.add_body(
        rb.Box(half),
        mass=2.0 * mass_ratio,
        position=(0.15, 0.1, 0.2 * np.sqrt(2)),
        orientation=multiply(turn((0, 0, 1), np.pi / 2), on_edge),
        linear_velocity=(0.3, -0.2, -1.0),
        friction=0.0,
        restitution=restitution,
    )
    found = rb.find_contacts(high, low, margin=1e-9)
    assert len(found) == 1
    N, point = found["normal"][0], found["point"][0]
    r_a, r_b = point - high.com_position, point - low.com_position
    a = 1 / high.mass + 1 / low.mass
    a += np.cross(r_a, N) @ inverse_inertia(high) @ np.cross(r_a, N)
    a += np.cross(r_b, N) @ inverse_inertia(low) @ np.cross(r_b, N)
    before = velocity_at(high, point) - velocity_at(low, point)
    f = -(1 + restitution) * (N @ before) / a
    v_high, v_low = high.linear_velocity + f * N / high.mass, -f * N / low.mass
    world.step()
    # Relative to the impulse and to the speeds it makes; after the impact both fly freely, so that
    # linear velocities and angular momenta stay.
    for body, v, moment in (
        (high, v_high, np.cross(r_a, f * N)),
        (low, v_low, -np.cross(r_b, f * N)),
    ):
        np.testing.assert_allclose(body.linear_velocity, v, atol=1e-12 * max(1, f / body.mass))
        L = np.linalg.inv(inverse_inertia(body)) @ body.angular_velocity
        np.testing.assert_allclose(L, moment, atol=1e-12 * f)
    contacts = world.contacts
    assert len(contacts) == 1
    np.testing.assert_allclose(
        contacts["impulse"][0] * (1 if contacts["body_a"][0] == high.row else -1),
        f * N,
        atol=1e-12 * f,
    )


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
def test_a_corner_strikes_the_floor(law, restitution):
    """v+ = N_perp - eps (N . v-) N holds for the velocity of the contact point when nothing slides."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-6, impact_law=law)
    world.add_body(
        rb.HalfSpace(normal=(0, 0, 1), offset=0.0),
        type="static",
        friction=0.0,
        restitution=restitution,
    )
    half = np.array([0.1, 0.2, 0.3])
    q = multiply(turn((1, 0, 0), 0.5), turn((0, 1, 0), 0.7))
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    lowest = min(corners @ rotation(q).T, key=lambda c: c[2])
    box = world.add_body(
        rb.Box(half),
        mass=1.5,
        position=(0, 0, -lowest[2]),
        orientation=q,
        linear_velocity=(0.5, 0, -2.0),
        angular_velocity=(1, -2, 3),
        friction=0.0,
    )
    before = velocity_at(box, box.position + lowest)
    assert before[2] < 0
    r, N = lowest, np.array([0, 0, 1.0])
    a = 1 / box.mass + np.cross(r, N) @ inverse_inertia(box) @ np.cross(r, N)
    f = -(1 + restitution) * before[2] / a
    v = box.linear_velocity + f * N / box.mass
    w = box.angular_velocity + inverse_inertia(box) @ np.cross(r, f * N)
    world.step()
    np.testing.assert_allclose(box.linear_velocity, v, atol=1e-12)
    # One microsecond of free rotation turns omega by up to omega² dt = 1e-5.
    np.testing.assert_allclose(box.angular_velocity, w, atol=2e-4)
    assert (v + np.cross(w, r))[2] == pytest.approx(-restitution * before[2], abs=1e-12)
