"""S16: resting contact: C = g N, g >= 0, d_ddot >= 0, g d_ddot = 0, seen in forces and kinematics."""

import numpy as np
import pytest

import rb_physics as rb
from benchmarks.stage import Stage, turn

G = 9.81


def pushed_box(force, point, friction=0.0, stepper="fixed", half=(0.2, 0.1, 0.3), dt=1e-3):
    world = rb.World(dt=dt, stepper=stepper)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", friction=friction)
    box = world.add_body(rb.Box(half), mass=2.0, position=(0, 0, half[2]), friction=friction)
    box.apply_wrench(force=force, point=point, frame="world" if point is None else "body")
    return world, box


@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize(
    ("force", "point"),
    [
        ((0, 0, 0), None),
        ((3.0, 0, 0), (0, 0, 0.3)),
        ((9.0, 0, 0), (0, 0, 0.3)),
        ((20.0, 4.0, 0), (0, 0, 0.3)),
        ((0, 0, -30.0), (0.2, 0.1, 0.3)),
        ((0, 0, 15.0), (0.2, 0.05, 0.3)),
        ((0, 0, 25.0), None),
    ],
)
def test_complementarity_of_forces_and_accelerations(stepper, force, point):
    """Each corner either carries or leaves: g >= 0, d_ddot >= 0 and not both positive."""
    world, box = pushed_box(force, point, stepper=stepper)
    world.step()
    contacts = world.contacts
    g = np.einsum("ij,ij->i", contacts["force"], contacts["normal"])
    assert (g >= -1e-10).all()
    # The step is 1 ms: accelerations from the velocities it made; terms of second order are 1e-2.
    for c, f in zip(contacts, g, strict=True):
        r = c["point"] - box.com_position
        speed = c["normal"] @ (box.linear_velocity + np.cross(box.angular_velocity, r))
        acceleration = speed / world.dt
        assert acceleration >= -0.1
        # Which of both is zero is sharp at the start of the step, where the corners touch.
        assert f <= 1e-9 or acceleration <= 0.1, (f, acceleration)
    total = box.contact_wrench[0][2]
    assert total >= 0
    if point is None:
        assert total == pytest.approx(max(2.0 * G - force[2], 0), abs=1e-10)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_a_push_below_the_tipping_point_shifts_the_load(stepper):
    """Frictionless box pushed at its centre: even. Pulled down off-centre: loads by the lever rule."""
    x, y = 0.12, -0.04
    world, _box = pushed_box((0, 0, -10.0), (x, y, 0.3), stepper=stepper)
    world.step(20)
    contacts = world.contacts
    points, forces = contacts["point"], contacts["force"]
    assert len(contacts) == 4
    assert forces[:, 2].sum() == pytest.approx(2 * G + 10, abs=1e-10)
    assert points[:, 0] @ forces[:, 2] == pytest.approx(10 * x, abs=1e-10)
    assert points[:, 1] @ forces[:, 2] == pytest.approx(10 * y, abs=1e-10)
    # Least forces: linear in the coordinates, sum (1 + x x_i / 0.2² + ...) / 4.
    expected = 2 * G / 4 + 10 / 4 * (1 + x * points[:, 0] / 0.04 + y * points[:, 1] / 0.01)
    np.testing.assert_allclose(forces[:, 2], expected, atol=1e-9)


@pytest.mark.parametrize("lift", [0.5, 0.999, 1.001, 3.0])
def test_lifting_off(lift):
    """A pull above the weight parts the contact; below it the floor carries the rest."""
    world, box = pushed_box((0, 0, lift * 2 * G), None)
    world.step(100)
    t = world.time
    if lift < 1:
        assert box.position[2] == pytest.approx(0.3, abs=1e-12)
        assert box.contact_wrench[0][2] == pytest.approx((1 - lift) * 2 * G, abs=1e-10)
    else:
        assert box.position[2] == pytest.approx(0.3 + 0.5 * (lift - 1) * G * t * t, abs=1e-12)
        assert not box.contact_wrench.any()


@pytest.mark.parametrize("stage", [Stage(), Stage(attitude=tuple(turn((1, -2, 1), 1.0)))])
@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_box_against_floor_and_wall(stage, stepper):
    """Pushed into a corner: the wall carries the push, the floor the weight, corners evenly."""
    from dataclasses import replace

    stage = replace(stage, stepper=stepper)
    world = stage.world(1e-3)
    stage.plane(world, (0, 0, 1), friction=0.0)
    stage.plane(world, (-1, 0, 0), -0.1, friction=0.0)  # x <= 0.1
    box = stage.add(world, stage.box((0.1, 0.1, 0.1)), 2.0, (0, 0, 0.1), friction=0.0)
    box.apply_wrench(force=stage.vector((5, 0, 0)))
    for _ in range(30):
        world.step()
        force = stage.force(box.contact_wrench[0])
        np.testing.assert_allclose(force, (-5, 0, 2 * G), atol=1e-10)
    forces = stage.force(world.contacts["force"])
    wall = world.contacts["body_b"] == 1
    np.testing.assert_allclose(forces[wall], np.tile((-1.25, 0, 0), (4, 1)), atol=1e-9)
    np.testing.assert_allclose(forces[~wall], np.tile((0, 0, G / 2), (4, 1)), atol=1e-9)


def test_a_box_under_a_ceiling_is_pressed_up():
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, -1), offset=0.0), type="static")
    box = world.add_body(rb.Box((0.1, 0.1, 0.1)), mass=2.0, position=(0, 0, -0.1))
    box.apply_wrench(force=(0, 0, 50.0))
    world.step(100)
    assert box.position[2] == pytest.approx(-0.1, abs=1e-12)
    np.testing.assert_allclose(box.contact_wrench[0], (0, 0, 2 * G - 50), atol=1e-10)
    assert not np.abs(box.contact_wrench[1]).max() > 1e-10
