"""Sends the messages of a recording when they are due; can be paused, stepped, sped up and moved."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any, Protocol

_NAP = 0.1  # s at most between two looks at what was asked for, `stop` included


class Messages(Protocol):
    """What is played: as `Recording` gives it."""

    def messages(self, topics: set[str], start: int) -> Iterator[Any]: ...
    def latest(self, topics: set[str], before: int) -> list[Any]: ...


class Player:
    """`run` plays in the calling thread; everything else may be called from any other."""

    def __init__(
        self,
        recording: Messages,
        topics: set[str],
        latched: set[str],
        publish: Callable[[Any], None],
        *,
        rate: float = 1.0,
        start: int = 0,
        loop: bool = False,
        paused: bool = False,
    ) -> None:
        """Args:
        topics: what is published; `latched` ones from before the start are published, too.
        rate: speed, 0 as fast as possible.
        start: ns of log time, of every round.
        """
        self._recording, self._topics, self._latched = recording, topics, latched
        self._publish = publish
        self._changed = threading.Condition()
        self._start, self._paused, self._rate, self.loop = start, paused, rate, loop
        self._next_start: int | None = None  # where `seek` wants to go on
        self._ahead = 0  # messages to be sent in spite of the pause
        self._anchor: tuple[float, int] | None = (
            None  # wall time (s) and log time that belong together
        )
        self._last: int | None = None  # ns of log time, of the last message or seek

    # -- asked for from other threads ---------------------------------------------------------------

    @property
    def paused(self) -> bool:
        return self._paused

    @property
    def position(self) -> int | None:
        """ns of log time: of the last message, or where `seek` went; None before the first."""
        with self._changed:
            return self._last if self._next_start is None else self._next_start

    def pause(self, paused: bool = True) -> None:
        with self._changed:
            self._paused, self._ahead, self._anchor = paused, 0, None
            self._changed.notify_all()

    def set_rate(self, rate: float) -> None:
        """Raises ValueError unless it is a finite number >= 0 (0: as fast as possible)."""
        check_rate(rate)
        with self._changed:
            self._rate, self._anchor = rate, None
            self._changed.notify_all()

    def play_next(self, count: int = 1) -> bool:
        """Sends the next messages while paused; False when it isn't."""
        with self._changed:
            if not self._paused:
                return False
            self._ahead += count
            self._changed.notify_all()
        return True

    def seek(self, time_ns: int) -> None:
        """Goes on from another moment, latched topics as they were then."""
        with self._changed:
            self._next_start, self._anchor, self._ahead = time_ns, None, 0
            self._changed.notify_all()

    # -- playing ------------------------------------------------------------------------------------

    def run(self, stop: threading.Event) -> None:
        """Until the end (for ever with `loop`) or until `stop` is set."""
        start = self._start
        while not stop.is_set():
            sent = self._play(start, stop)
            with self._changed:
                found, self._next_start = self._next_start, None
                self._anchor = None
                self._last = found if found is not None else self._last
            if found is not None:
                start = found
            elif self.loop and sent:
                start = self._start
            else:
                return

    def _play(self, start: int, stop: threading.Event) -> bool:
        """From one moment to the end, or to a seek; whether anything was sent."""
        sent = False
        for message in self._recording.latest(self._latched, start) if start > 0 else ():
            self._publish(message)
        for message in self._recording.messages(self._topics, start):
            if not self._wait(message.log_time, stop):
                break
            self._publish(message)
            self._last = message.log_time
            sent = True
        return sent

    def _wait(self, log_time: int, stop: threading.Event) -> bool:
        """Returns when a message is due; False when it won't be, for a seek or the end."""
        while not stop.is_set():
            with self._changed:
                if self._next_start is not None:
                    return False
                if self._paused:
                    if self._ahead > 0:
                        self._ahead -= 1
                        return True
                    self._changed.wait(_NAP)
                    continue
                if self._rate == 0.0:
                    return True
                now = time.monotonic()
                if self._anchor is None:
                    self._anchor = (now, log_time)
                left = self._anchor[0] + (log_time - self._anchor[1]) * 1e-9 / self._rate - now
                if left <= 0.0:
                    return True
                self._changed.wait(min(left, _NAP))
        return False


def check_rate(rate: float) -> None:
    """Raises ValueError unless it is a finite number >= 0."""
    if not 0.0 <= rate < math.inf:
        raise ValueError(f"parameter rate is {rate}, but must be a finite number >= 0")
