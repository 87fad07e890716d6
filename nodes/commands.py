"""Orders to the physics thread, carried out at a step boundary and answered."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field
from typing import Any

Answer = tuple[bool, str]  # success, message: the fields of std_srvs responses


@dataclass
class Command:
    """One order; `done` is set once `answer` holds."""

    name: str
    arguments: tuple[Any, ...] = ()
    answer: Answer = (False, "")
    done: threading.Event = field(default_factory=threading.Event)

    def finish(self, success: bool, message: str) -> None:
        self.answer = (success, message)
        self.done.set()


class CommandQueue:
    """Orders in the sequence in which they came, from any thread to the physics thread."""

    def __init__(self) -> None:
        self._waiting: deque[Command] = deque()
        self._lock = threading.Lock()
        self._closed = False
        self._wake = threading.Event()

    def ask(self, name: str, *arguments: Any) -> Answer:
        """Hand an order over and wait for its answer."""
        command = Command(name, arguments)
        with self._lock:
            if self._closed:
                return False, "the simulator is shutting down"
            self._waiting.append(command)
        self._wake.set()
        command.done.wait()
        return command.answer

    def take(self) -> Command | None:
        """The next order, if any."""
        with self._lock:
            return self._waiting.popleft() if self._waiting else None

    def wake(self) -> None:
        """Let a `rest` in progress end now."""
        self._wake.set()

    def rest(self, seconds: float) -> None:
        """Wait for an order or another reason to wake up, at most `seconds`."""
        self._wake.wait(seconds)
        self._wake.clear()

    def close(self) -> None:
        """Answer everything that still waits, and everything to come, with a refusal."""
        with self._lock:
            self._closed = True
            waiting, self._waiting = list(self._waiting), deque()
        for command in waiting:
            command.finish(False, "the simulator is shutting down")
