"""Wrench messages as the world gets them: per source, at step boundaries, with their timeout."""

import math

import pytest
from rb_physics_nodes.refused import RefusedValueError
from rb_physics_nodes.wrench_frames import WrenchFrames
from rb_physics_nodes.wrench_inputs import HeldWrenches, WrenchInputs, WrenchSource

import rb_physics as rb

ZERO = (0.0, 0.0, 0.0)


BOX = WrenchFrames("box", ZERO, {})


def make(timeout, sources=("0", "1")):
    inputs = WrenchInputs(1e-3, timeout)
    inputs.fit([WrenchSource(source, "box") for source in sources], {"box": BOX})
    return inputs


def hold(inputs, source, frame, force):
    wrench = inputs.resolve("box", frame, force, ZERO)
    inputs.hold(str(source), HeldWrenches.of("box", wrench))


class Floating:
    """A free 1 kg sphere; `perform` is what the recorder does."""

    def __init__(self):
        self.world = rb.World(gravity=ZERO, dt=1e-3)
        self.body = self.world.add_body(rb.Sphere(radius=0.1), mass=1.0, name="box")

    def perform(self, name, body, **arguments):
        getattr(self.world[body], name)(**arguments)

    def step(self, inputs, count=1):
        inputs.apply(self.world.step_count, self.perform)
        self.world.step(count)

    @property
    def momentum(self):
        return tuple(self.world.linear_momentum)


# 1e-15: sums of up to some hundred equal impulses of a few mN s
ROUNDING = {"abs": 1e-15, "rel": 1e-14}


@pytest.mark.parametrize(
    ("timeout", "impulse"), [(0.0, 2e-3), (0.001, 2e-3), (0.0015, 3e-3), (0.1, 0.2)]
)
def test_a_wrench_gives_force_times_timeout_and_at_least_one_step(timeout, impulse):
    inputs, floating = make(timeout), Floating()
    hold(inputs, 0, "world", (2.0, 0.0, 0.0))
    floating.step(inputs, 300)
    assert floating.momentum == pytest.approx((impulse, 0.0, 0.0), **ROUNDING)
    assert inputs.active(floating.world.step_count) == 0


def test_minus_one_holds_for_ever():
    inputs, floating = make(-1.0), Floating()
    hold(inputs, 0, "world", (2.0, 0.0, 0.0))
    floating.step(inputs, 300)
    assert floating.momentum == pytest.approx((0.6, 0.0, 0.0), **ROUNDING)
    assert inputs.active(10**9) == 1


def test_sources_add_up_and_expire_each_on_their_own():
    inputs, floating = make(0.01), Floating()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0))
    floating.step(inputs, 5)
    hold(inputs, 1, "world", (0.0, 2.0, 0.0))
    floating.step(inputs, 5)
    assert floating.momentum == pytest.approx((0.01, 0.01, 0.0), **ROUNDING)
    floating.step(inputs, 100)
    assert floating.momentum == pytest.approx((0.01, 0.02, 0.0), **ROUNDING)


def test_the_next_message_of_a_source_replaces_its_last():
    inputs, floating = make(0.01), Floating()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0))
    floating.step(inputs, 5)
    hold(inputs, 0, "world", (3.0, 0.0, 0.0))
    floating.step(inputs, 100)
    assert floating.momentum == pytest.approx((0.005 + 0.03, 0.0, 0.0), **ROUNDING)


def test_of_two_messages_at_one_boundary_the_later_one_counts():
    inputs, floating = make(0.0), Floating()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0))
    hold(inputs, 0, "world", (3.0, 0.0, 0.0))
    floating.step(inputs, 10)
    assert floating.momentum == pytest.approx((0.003, 0.0, 0.0), **ROUNDING)


def test_body_axes_turn_with_the_body_and_world_axes_do_not():
    inputs, floating = make(0.0), Floating()
    floating.body.orientation = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))  # x to y
    hold(inputs, 0, "world", (1.0, 0.0, 0.0))
    hold(inputs, 1, "box/com", (1.0, 0.0, 0.0))
    floating.step(inputs)
    assert floating.momentum == pytest.approx((0.001, 0.001, 0.0), **ROUNDING)


def test_clear_lets_go_and_counts():
    inputs, floating = make(-1.0), Floating()
    hold(inputs, 0, "world", (1.0, 0.0, 0.0))
    floating.step(inputs)
    hold(inputs, 1, "world", (1.0, 0.0, 0.0))  # not yet handed over
    assert inputs.clear(1, floating.perform) == 2
    floating.step(inputs, 10)
    assert floating.momentum == pytest.approx((0.001, 0.0, 0.0), **ROUNDING)
    assert inputs.active(1) == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    inputs = make(0.1)
    with pytest.raises(RefusedValueError, match=r"'box'.*must be finite"):
        inputs.resolve("box", "world", (0.0, bad, 0.0), ZERO)
    with pytest.raises(RefusedValueError, match="must be finite"):
        inputs.resolve("box", "world", ZERO, (0.0, 0.0, bad))


@pytest.mark.parametrize("timeout", [-0.5, -2.0, math.nan, math.inf])
def test_impossible_timeouts_are_refused(timeout):
    with pytest.raises(ValueError, match=r"wrench_timeout is .* must be >= 0 s, or -1"):
        make(timeout)
