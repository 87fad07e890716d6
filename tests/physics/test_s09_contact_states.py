"""S9: N . V < 0 colliding, = 0 resting, > 0 separating, V from v + omega x r of both bodies."""

import numpy as np
import pytest

import rb_physics as rb

State = rb.ContactState


def test_the_sign_of_the_normal_speed_decides():
    world = rb.World(gravity=(0, 0, -9.81), dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", restitution=1.0)
    rest = world.add_body(rb.Sphere(0.1), mass=1.0, position=(0, 0, 0.1))
    bounce = world.add_body(
        rb.Sphere(0.1), mass=1.0, position=(1, 0, 0.1), linear_velocity=(0, 0, -1)
    )
    world.step()
    states = {int(c["body_a"]): State(c["state"]) for c in world.contacts}
    # The bounced ball left within the step: its row stands for the impulse it carried.
    assert states == {rest.row: State.RESTING, bounce.row: State.SEPARATING}


@pytest.mark.parametrize("spin", [(0, 0, 0), (0, 3, 0), (5, -7, 2)])
def test_rotation_of_both_bodies_counts(spin):
    """Only N . V matters: sliding and spinning on the spot rest."""
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=0.0)
    world.add_body(
        rb.Sphere(0.1),
        mass=1.0,
        position=(0, 0, 0.1),
        linear_velocity=(3, -1, 0),
        angular_velocity=spin,
        friction=0.0,
    )
    world.step(10)
    assert [State(s) for s in world.contacts["state"]] == [State.RESTING]


def test_colliding_is_seen_when_a_step_ends_at_the_contact():
    """A ball that touches exactly at the end of a step still moves towards the floor."""
    world = rb.World(gravity=(0, 0, 0), dt=0.25)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static")
    world.add_body(
        rb.Sphere(0.5), mass=1.0, position=(0, 0, 1.0), linear_velocity=(0, 0, -2.0), restitution=0
    )
    world.step()
    states = [State(s) for s in world.contacts["state"]]
    # 0.5 m in 0.25 s at 2 m/s, all exact in binary. Struck at once or at the start of the next step.
    assert states in ([State.COLLIDING], [State.RESTING])
    world.step()
    assert [State(s) for s in world.contacts["state"]] == [State.RESTING]


def test_a_box_that_tips_has_two_resting_and_two_departing_corners():
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=1.0)
    box = world.add_body(rb.Box((0.1, 0.1, 0.3)), mass=1.0, position=(0, 0, 0.3), friction=1.0)
    box.apply_wrench(force=(5.0, 0, 0), point=(0, 0, 0.3), frame="body")
    world.step()
    contacts = world.contacts
    carrying = contacts[np.linalg.norm(contacts["impulse"], axis=1) > 0]
    assert len(carrying) == 2
    np.testing.assert_allclose(carrying["point"][:, 0], 0.1, atol=1e-5)  # moved by a dt² of 5 m/s²
    for c in contacts[np.linalg.norm(contacts["impulse"], axis=1) == 0]:
        assert State(c["state"]) == State.SEPARATING
