"""The bounded queue between the simulation and the threads that write."""

from __future__ import annotations

import threading
from collections import deque
from typing import NamedTuple

POLICIES = ("block", "drop_oldest")


class Entry(NamedTuple):
    """One message on its way to the log."""

    topic: int  # id of the topic
    log_time: int  # ns, never decreasing
    step: int  # steps since the start of the recording
    data: bytes


class MessageQueue:
    """Bounded in bytes. When full, `put` blocks (lossless) or drops the oldest messages, counted.

    Topics in `essential` (what a repetition of the run needs) are never dropped.
    """

    def __init__(self, limit_bytes: int, policy: str) -> None:
        if policy not in POLICIES:
            raise ValueError(f"queue policy {policy!r} is not one of {', '.join(POLICIES)}")
        self._limit, self._policy = limit_bytes, policy
        self._entries: deque[Entry] = deque()
        self._bytes = 0
        self._closed = False
        self._changed = threading.Condition()
        self.essential: set[int] = set()
        self.dropped = 0  # messages lost to the limit
        self.blocked = 0  # times `put` had to wait

    @property
    def queued_bytes(self) -> int:
        return self._bytes

    def put(self, entries: list[Entry]) -> None:
        """Adds messages; after `close` they are ignored."""
        size = sum(len(entry.data) for entry in entries)
        with self._changed:
            if self._bytes + size > self._limit and self._policy == "block" and self._entries:
                self.blocked += 1
                self._changed.notify_all()
                self._changed.wait_for(
                    lambda: self._closed or not self._entries or self._bytes + size <= self._limit
                )
            if self._closed:
                return
            self._entries.extend(entries)
            self._bytes += size
            if self._bytes > self._limit and self._policy == "drop_oldest":
                self._drop()
            elif self._bytes > self._limit // 2:  # the writer wakes by itself otherwise
                self._changed.notify_all()

    def _drop(self) -> None:
        """Down to three quarters of the limit, so that the search is rare."""
        kept: deque[Entry] = deque()
        while self._entries and self._bytes > self._limit * 3 // 4:
            entry = self._entries.popleft()
            if entry.topic in self.essential:
                kept.append(entry)
            else:
                self._bytes -= len(entry.data)
                self.dropped += 1
        self._entries.extendleft(reversed(kept))

    def take(self, timeout: float) -> list[Entry]:
        """Everything queued after waiting `timeout` s, or less when it fills or closes."""
        with self._changed:
            if not self._closed and self._bytes <= self._limit // 2:
                self._changed.wait(timeout)
            entries = list(self._entries)
            self._entries.clear()
            self._bytes = 0
            self._changed.notify_all()
        return entries

    def close(self) -> None:
        """Wakes everybody; what is queued can still be taken."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def closed(self) -> bool:
        return self._closed
