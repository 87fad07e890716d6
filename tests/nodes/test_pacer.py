"""Deadlines in real time: what is due, what was late, what was given up. With a clock of the test."""

import pytest
from rb_physics_nodes import pacer as module
from rb_physics_nodes.pacer import MAX_LAG, Pacer


class FakeTime:
    """time.monotonic and time.sleep; sleeping takes exactly as long as asked for."""

    def __init__(self):
        self.now = 100.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    clock = FakeTime()
    monkeypatch.setattr(module, "time", clock)
    return clock


def test_steps_are_due_at_absolute_deadlines(clock):
    pacer = Pacer(0.001, 1.0)
    pacer.restart(0)
    for step in range(10):
        assert pacer.wait(step) == 1
        # rounding of a time of about 100 s
        assert clock.now == pytest.approx(100.0 + (step + 1) * 0.001, abs=1e-12)
        clock.now += 0.0004  # what the step takes
    assert (pacer.missed_deadlines, pacer.lost_steps) == (0, 0)


def test_late_steps_are_made_at_once_and_each_counted_once(clock):
    pacer = Pacer(0.001, 1.0)
    pacer.restart(0)
    assert pacer.wait(0) == 1
    clock.now += 0.0105  # something took ten steps' time
    for step, due in ((1, 10), (2, 9), (3, 8)):  # one step made for each look
        assert pacer.wait(step) == due
    assert pacer.missed_deadlines == 9
    assert pacer.wait(4) == 7
    assert pacer.missed_deadlines == 9
    assert pacer.lost_steps == 0


def test_too_large_a_debt_is_given_up_and_counted(clock):
    pacer = Pacer(0.001, 1.0)
    pacer.restart(0)
    assert pacer.wait(0) == 1
    clock.now += MAX_LAG + 0.1
    assert pacer.wait(1) == 1
    # 350 ms are 350 steps, one of which is made now; 2: rounding of the division
    assert pacer.lost_steps == pytest.approx(349, abs=2)
    assert pacer.wait(2) == 1  # from here on as if nothing had happened
    assert pacer.lost_steps == pytest.approx(349, abs=2)


def test_other_work_ends_before_the_deadline(clock):
    pacer = Pacer(0.01, 1.0)
    pacer.restart(0)
    ends = []

    def work(end):
        ends.append(end)
        clock.now = end

    assert pacer.wait(0, work) == 1
    assert 100.0 < ends[0] < 100.01
    assert clock.now == pytest.approx(100.01, abs=1e-12)


def test_as_fast_as_possible_has_no_deadlines(clock):
    pacer = Pacer(0.001, 0.0)
    pacer.restart(0)
    assert pacer.wait(5) > 10**6
    assert clock.now == 100.0
