"""Messages on their way from the executor to the physics thread."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

CAPACITY = 100_000  # messages that may wait; more are dropped and counted


class Inbox:
    """Raw messages in their order of arrival, each with the name of its topic."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._arrived: deque[tuple[str, bytes]] = deque()
        self._capacity = capacity
        self._lock = threading.Lock()
        self.received = 0
        self.dropped = 0

    def put(self, topic: str, data: bytes) -> None:
        """Called for every message, in the thread that reads them."""
        with self._lock:
            self.received += 1
            if len(self._arrived) >= self._capacity:
                self.dropped += 1
            else:
                self._arrived.append((topic, data))

    def take(self, rank: Callable[[str], int]) -> list[tuple[str, bytes]]:
        """Everything that has arrived: by rank of its topic, in its order of arrival on each."""
        if not self._arrived:
            return []
        with self._lock:
            arrived = list(self._arrived)
            self._arrived.clear()
        arrived.sort(key=lambda message: rank(message[0]))
        return arrived
