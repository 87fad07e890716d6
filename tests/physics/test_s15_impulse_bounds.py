"""S15: bounds on f for one contact: -d_dot / a <= f <= -2 d_dot / a, spanned by eps in [0, 1]."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import multiply, rotation, turn


def edge_contact(restitution, law, seed):
    """Two boxes that meet with crossed edges at random arms and velocities; the bound's numbers."""
    rng = np.random.default_rng(seed)
    # So short that what follows the impact does not show in the impulse.
    world = rb.World(gravity=(0, 0, 0), dt=1e-13, impact_law=law)
    on_edge = turn((0, 1, 0), np.pi / 4)
    common = {"friction": 0.0, "restitution": restitution}
    low = world.add_body(
        rb.Box((0.1, 0.5, 0.1)),
        mass=10 ** rng.uniform(-1, 1),
        orientation=on_edge,
        linear_velocity=rng.normal(size=3) + (0, 0, 2),
        angular_velocity=rng.normal(size=3),
        **common,
    )
    high = world.add_body(
        rb.Box((0.1, 0.5, 0.1)),
        mass=10 ** rng.uniform(-1, 1),
        position=(*rng.uniform(-0.2, 0.2, 2), 0.2 * np.sqrt(2)),
        orientation=multiply(turn((0, 0, 1), rng.uniform(1, 2)), on_edge),
        linear_velocity=rng.normal(size=3) - (0, 0, 2),
        angular_velocity=rng.normal(size=3),
        **common,
    )
    found = rb.find_contacts(high, low, margin=1e-9)
    assert len(found) == 1
    N, point = found["normal"][0], found["point"][0]
    a, d_dot = 0.0, 0.0
    for body, sign in ((high, 1), (low, -1)):
        r = point - body.com_position
        R = rotation(body.orientation)
        arm = np.cross(r, N)
        a += 1 / body.mass + arm @ R @ np.linalg.inv(body.inertia) @ R.T @ arm
        d_dot += sign * N @ (body.linear_velocity + np.cross(body.angular_velocity, r))
    return world, a, d_dot


@pytest.mark.parametrize("law", ["sequential", "simultaneous", "reflections"])
@pytest.mark.parametrize("restitution", [0.0, 0.25, 1.0])
def test_impulse_lies_where_eps_puts_it(law, restitution):
    struck = 0
    for seed in range(20):
        world, a, d_dot = edge_contact(restitution, law, seed)
        if d_dot >= -0.1:
            continue
        struck += 1
        world.step()
        f = np.linalg.norm(world.contacts["impulse"].sum(axis=0))
        assert -d_dot / a * (1 - 1e-12) <= f <= -2 * d_dot / a * (1 + 1e-12)
        assert f == pytest.approx(-(1 + restitution) * d_dot / a, rel=1e-12)
    assert struck >= 10
