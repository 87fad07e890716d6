"""Where the edge of body A met a curved surface, the contact point was moved with the edge, not with what
slid along it: a ball on two rails turned them about the wrong points, and did something else when it
was added in the other order."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import turn

SIDE = 0.1 * np.sqrt(2)  # m, of a rail turned by 45 degrees: half its diagonal
APART = 0.145  # m, half the distance of the rails, which do not touch each other


def ride(order, rider, stepper):
    """A rider pressed onto the upper edges of two free rails slides along them."""
    world = rb.World(gravity=(0, 0, 0), dt=1e-3, stepper=stepper)
    bodies = {}
    for name in order:
        if name == "rider":
            height = SIDE + np.sqrt(0.2**2 - APART**2)
            bodies[name] = world.add_body(
                rider,
                mass=1.0,
                position=(0.4, 0, height),
                linear_velocity=(2.0, 0, 0),
                friction=0.0,
            )
            bodies[name].apply_wrench((0, 0, -50.0), (0, 0, 0))
        else:
            y = APART if name == "left" else -APART
            bodies[name] = world.add_body(
                rb.Box((1.0, 0.1, 0.1)),
                mass=4.0,
                position=(0, y, 0),
                orientation=turn((1, 0, 0), np.pi / 4),
                friction=0.0,
            )
    world.step(30)
    assert len(world.contacts) >= 2
    return np.array(
        [
            np.r_[b.com_position, b.linear_velocity, b.angular_velocity]
            for _, b in sorted(bodies.items())
        ]
    )


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("rider", [rb.Sphere(0.2), rb.Capsule(0.2, 0.1)], ids=["sphere", "capsule"])
def test_order_of_rails_and_rider(rider, stepper):
    one = ride(("left", "right", "rider"), rider, stepper)
    other = ride(("rider", "left", "right"), rider, stepper)
    assert np.abs(one[0, 7]) > 1e-3  # rad/s, the rails turn under the rider
    np.testing.assert_allclose(
        one, other, rtol=0, atol=1e-11
    )  # rounding of thirty steps with some solves each
