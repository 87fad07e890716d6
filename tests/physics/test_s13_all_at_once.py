"""S13: simultaneous contacts. The notes' wedge: single impulses, their average, and all at once."""

import numpy as np
import pytest
from wedge import N0, N1, particle_in_wedge

from benchmarks.stage import Stage, turn

STAGES = {
    "flat": Stage(),
    "turned": Stage(attitude=tuple(turn((1, 2, -1), 1.3))),
    "small_and_heavy": Stage(size=1e-2, mass=1e3),
}
everywhere = pytest.mark.parametrize("stage", STAGES.values(), ids=STAGES)


@everywhere
@pytest.mark.parametrize("speed", [1.0, 3.0])
def test_each_wall_alone_and_the_average_is_blocked(stage, speed):
    alone = []
    for wall in (0, 1):
        world, ball, _ = particle_in_wedge(stage, walls=(wall,), speed=speed)
        world.step()
        alone.append(stage.velocity(ball))
    # The notes' numbers (with their two slips put right).
    np.testing.assert_allclose(alone[0], (speed, 0, 0), atol=1e-12 * speed)
    np.testing.assert_allclose(alone[1], (-0.8 * speed, 0, -0.6 * speed), atol=1e-12 * speed)
    average = (alone[0] + alone[1]) / 2
    np.testing.assert_allclose(average, (0.1 * speed, 0, -0.3 * speed), atol=1e-12 * speed)
    assert N1 @ alone[0] < 0 and N0 @ alone[1] < 0 and N0 @ average < 0 and N1 @ average < 0


@everywhere
@pytest.mark.parametrize("stepper", ["fixed", "event"])
@pytest.mark.parametrize("speed", [1.0, 3.0])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_both_walls_at_once_throw_it_straight_back(stage, stepper, speed, order):
    from dataclasses import replace

    stage = replace(stage, stepper=stepper)
    world, ball, _ = particle_in_wedge(stage, order, speed=speed)
    world.step()
    np.testing.assert_allclose(stage.velocity(ball), (0, 0, speed), atol=1e-12 * speed)


@everywhere
@pytest.mark.parametrize("law", ["simultaneous", "reflections"])
def test_both_walls_without_rebound_stop_it(stage, law):
    from dataclasses import replace

    stage = replace(stage, impact_law=law)
    world, ball, _ = particle_in_wedge(stage, restitution=0.0)
    world.step()
    np.testing.assert_allclose(stage.velocity(ball), 0, atol=1e-12)


@pytest.mark.parametrize("restitution", [0.2, 0.7])
def test_partial_rebound_reverses_both_normal_speeds(restitution):
    """The ball can reverse both contact speeds by eps: v+ = eps (0, speed)."""
    world, ball, _ = particle_in_wedge(Stage(), restitution=restitution)
    world.step()
    np.testing.assert_allclose(ball.linear_velocity, (0, 0, restitution), atol=1e-12)


@pytest.mark.parametrize("law", ["simultaneous", "reflections"])
def test_the_order_of_walls_does_not_matter(law):
    answers = []
    for order in ((0, 1), (1, 0)):
        world, ball, _ = particle_in_wedge(Stage(impact_law=law), order)
        world.step()
        answers.append(ball.linear_velocity)
    np.testing.assert_allclose(*answers, atol=1e-12)


@pytest.mark.parametrize("stepper", ["fixed", "event"])
def test_a_box_lands_flat_and_bounces_flat(stepper):
    """Four corners at once share the impulse: no rotation, eps of the speed."""
    world = Stage(stepper=stepper).world(1e-3)
    Stage().plane(world, restitution=0.5)
    stage = Stage()
    box = stage.add(world, stage.box((0.2, 0.1, 0.05)), 3.0, (0, 0, 0.15), spin=(0, 0, 2.0))
    world.step(150)
    fall = np.sqrt(2 * 0.1 / 9.81)
    t = world.time - fall
    assert stage.velocity(box)[2] == pytest.approx(0.5 * 9.81 * fall - 9.81 * t, abs=1e-9)
    np.testing.assert_allclose(box.angular_velocity[:2], 0, atol=1e-12)
