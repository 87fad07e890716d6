"""Held wrenches: sums over sources, expiry in steps, the same whatever the body's attitude."""

import math

import numpy as np
import pytest
from rb_physics_nodes.refused import RefusedValueError
from rb_physics_nodes.wrench_frames import WrenchFrames
from rb_physics_nodes.wrench_inputs import WrenchInputs, WrenchSource

ZERO = (0.0, 0.0, 0.0)


class Recorded:
    """Stands for world and recorder: remembers what is applied to each body."""

    def __init__(self, orientation=(0.0, 0.0, 0.0, 1.0)):
        self.orientation = orientation
        self.applied = {}

    def __getitem__(self, name):
        return self

    def perform(self, name, body, **wrench):
        if name == "clear_wrenches":
            del self.applied[body]
        else:
            self.applied[body] = wrench


def make(timeout, sources=("", "gust")):
    listed = [WrenchSource("box", source, f"/box/wrench/{source}") for source in sources]
    return WrenchInputs(listed, {"box": WrenchFrames("box", ZERO, {})}, 1e-3, timeout)


def hold(inputs, source, frame, force, step):
    inputs.hold(source, inputs.resolve(source, frame, force, ZERO), step)


@pytest.mark.parametrize(
    ("timeout", "steps"), [(0.0, 1), (0.001, 1), (0.0015, 2), (0.1, 100), (0.3, 300)]
)
def test_a_wrench_acts_for_its_timeout(timeout, steps):
    inputs, world = make(timeout), Recorded()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 7)
    inputs.apply(world, 7, world.perform)
    assert inputs.steps_unchanged(7) == steps
    inputs.apply(world, 7 + steps - 1, world.perform)
    assert "box" in world.applied
    inputs.apply(world, 7 + steps, world.perform)
    assert world.applied == {}


def test_minus_one_holds_for_ever():
    inputs, world = make(-1.0), Recorded()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 0)
    inputs.apply(world, 0, world.perform)
    assert inputs.steps_unchanged(0) is None
    inputs.apply(world, 10**9, world.perform)
    assert "box" in world.applied


def test_sources_add_up_and_expire_each_on_their_own():
    inputs, world = make(0.01), Recorded()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 0)
    hold(inputs, 1, "world", (0.0, 2.0, 0.0), 5)
    inputs.apply(world, 5, world.perform)
    assert world.applied["box"]["force"] == (1.0, 2.0, 0.0)
    inputs.apply(world, 10, world.perform)
    assert world.applied["box"]["force"] == (0.0, 2.0, 0.0)
    inputs.apply(world, 15, world.perform)
    assert world.applied == {}


def test_the_next_message_of_a_source_replaces_its_last():
    inputs, world = make(0.01), Recorded()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 0)
    hold(inputs, 0, "world", (3.0, 0.0, 0.0), 5)
    inputs.apply(world, 5, world.perform)
    assert world.applied["box"]["force"] == (3.0, 0.0, 0.0)
    inputs.apply(world, 14, world.perform)
    assert "box" in world.applied


def test_body_and_world_axes_together_are_summed_anew_in_every_step():
    quarter_turn_z = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    inputs, world = make(1.0), Recorded(quarter_turn_z)
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 0)
    hold(inputs, 1, "box/com", (1.0, 0.0, 0.0), 0)
    inputs.apply(world, 0, world.perform)
    assert inputs.steps_unchanged(0) == 1
    assert world.applied["box"]["frame"] == "world"
    # 1e-15: rounding of one rotation of a unit vector
    np.testing.assert_allclose(world.applied["box"]["force"], (1.0, 1.0, 0.0), atol=1e-15)
    world.orientation = (0.0, 0.0, 0.0, 1.0)
    inputs.apply(world, 1, world.perform)
    np.testing.assert_allclose(world.applied["box"]["force"], (2.0, 0.0, 0.0), atol=1e-15)


def test_clear_lets_go():
    inputs, world = make(-1.0), Recorded()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0), 0)
    inputs.apply(world, 0, world.perform)
    inputs.clear()
    inputs.apply(world, 1, world.perform)
    assert world.applied == {}
    assert inputs.active == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    inputs = make(0.1)
    with pytest.raises(RefusedValueError, match=r"'box'.*must be finite"):
        inputs.resolve(0, "world", (0.0, bad, 0.0), ZERO)
    with pytest.raises(RefusedValueError, match="must be finite"):
        inputs.resolve(0, "world", ZERO, (0.0, 0.0, bad))


@pytest.mark.parametrize("timeout", [-0.5, -2.0, math.nan, math.inf])
def test_impossible_timeouts_are_refused(timeout):
    with pytest.raises(ValueError, match=r"wrench_timeout is .* must be >= 0 s, or -1"):
        make(timeout)
