"""Messages on their way from the executor to the physics thread."""

from __future__ import annotations

import threading
from collections import deque

CAPACITY = 100_000  # messages that may wait; more are dropped and counted


class Inbox:
    """Raw messages in their order of arrival, each with the index of its topic."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._arrived: deque[tuple[int, bytes]] = deque()
        self._capacity = capacity
        self._lock = threading.Lock()
        self.received = 0
        self.dropped = 0

    def put(self, topic: int, data: bytes) -> None:
        """Called for every message, in the executor's thread."""
        with self._lock:
            self.received += 1
            if len(self._arrived) >= self._capacity:
                self.dropped += 1
            else:
                self._arrived.append((topic, data))

    def take(self) -> list[tuple[int, bytes]]:
        """Everything that has arrived: by topic index, and in its order of arrival on each topic."""
        if not self._arrived:
            return []
        with self._lock:
            arrived = list(self._arrived)
            self._arrived.clear()
        arrived.sort(key=lambda message: message[0])
        return arrived

    def put_back(self, messages: list[tuple[int, bytes]]) -> None:
        """Return messages that belong to a later step, before those that arrived meanwhile."""
        with self._lock:
            self._arrived.extendleft(reversed(messages))
