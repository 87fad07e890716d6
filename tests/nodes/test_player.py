"""The player of recordings, without ROS: timing, pause, steps, speed, seeking, rounds."""

from __future__ import annotations

import threading
import time

import pytest
from rb_physics_nodes.player import Player

from rb_physics.recording.log_reader import LogMessage


class Tape:
    """Message k of topic /t at k * 10 ms, 100 of them; /latched at 0 and 500 ms."""

    def __init__(self) -> None:
        self.all = [LogMessage("/t", "", k * 10_000_000, k, b"") for k in range(100)]
        self.all += [LogMessage("/latched", "", k * 500_000_000, k, b"") for k in range(2)]
        self.all.sort(key=lambda m: m.log_time)

    def messages(self, topics, start):
        return (m for m in self.all if m.topic in topics and m.log_time >= start)

    def latest(self, topics, before):
        last = {m.topic: m for m in self.all if m.topic in topics and m.log_time < before}
        return list(last.values())


@pytest.fixture
def play():
    """play(**options) -> (player, what it sent so far, the thread it runs in)."""
    stop, threads = threading.Event(), []

    def start(**options):
        sent = []
        player = Player(Tape(), {"/t", "/latched"}, {"/latched"}, sent.append, **options)
        thread = threading.Thread(target=player.run, args=(stop,))
        threads.append(thread)
        thread.start()
        return player, sent, thread

    yield start
    stop.set()
    for thread in threads:
        thread.join(5)
        assert not thread.is_alive()


def wait_for(condition, seconds=5.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_as_fast_as_possible_and_at_a_rate(play):
    _, sent, thread = play(rate=0.0)
    thread.join(5)
    assert len(sent) == 102
    began = time.monotonic()
    _, sent, thread = play(rate=5.0)
    thread.join(5)
    assert len(sent) == 102
    # 0.99 s at five times the speed; never early, and late only as much as the machine is busy.
    assert 0.198 <= time.monotonic() - began < 2.0


def test_start_sends_what_was_latched_before(play):
    _, sent, thread = play(rate=0.0, start=700_000_000)
    thread.join(5)
    assert [(m.topic, m.log_time) for m in sent[:2]] == [
        ("/latched", 500_000_000), ("/t", 700_000_000)
    ]  # fmt: skip
    assert len(sent) == 31


def test_paused_it_waits_and_steps(play):
    player, sent, thread = play(rate=0.0, paused=True)
    time.sleep(0.1)
    assert sent == []
    assert player.play_next(3)
    wait_for(lambda: len(sent) == 3)
    time.sleep(0.05)
    assert len(sent) == 3
    player.pause(False)
    thread.join(5)
    assert len(sent) == 102
    assert not player.play_next()


def test_a_pause_takes_no_time_of_the_recording(play):
    player, sent, thread = play(rate=2.0)
    wait_for(lambda: len(sent) > 20)
    player.pause()
    time.sleep(0.05)
    held = len(sent)
    time.sleep(0.3)
    assert len(sent) == held
    began = time.monotonic()
    player.pause(False)
    thread.join(5)
    # What was left is played at its own pace, not at once to make up for the pause.
    left = (102 - held) * 0.01 / 2.0
    assert time.monotonic() - began > 0.8 * left


def test_seek_forwards_and_back(play):
    player, sent, thread = play(rate=0.0, paused=True)
    player.play_next(5)
    wait_for(lambda: len(sent) == 5)
    player.seek(900_000_000)
    player.play_next()
    wait_for(lambda: len(sent) == 7)
    assert [m.log_time for m in sent[5:]] == [500_000_000, 900_000_000]
    player.seek(0)
    player.pause(False)
    thread.join(5)
    assert len(sent) == 7 + 102


def test_the_position_is_where_seek_went(play):
    player, sent, _ = play(rate=0.0, paused=True)
    assert player.position is None
    player.play_next()
    wait_for(lambda: player.position == 0 and sent)
    player.seek(700_000_000)
    assert player.position == 700_000_000
    wait_for(lambda: len(sent) == 2)  # what was latched then; the player has moved
    assert player.position == 700_000_000


def test_rounds_go_on_until_loop_is_taken_back(play):
    player, sent, thread = play(rate=0.0, loop=True, start=980_000_000)
    wait_for(lambda: len(sent) > 50)
    player.loop = False
    thread.join(5)
    assert not thread.is_alive()


@pytest.mark.parametrize("rate", [-1.0, float("nan"), float("inf")])
def test_rates_that_are_none(play, rate):
    player, _, _ = play(rate=0.0, paused=True)
    with pytest.raises(ValueError, match="must be a finite number >= 0"):
        player.set_rate(rate)
