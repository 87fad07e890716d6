"""The Rerun view of a run that goes on, made by a thread of its own."""

from __future__ import annotations

import threading

from .message_queue import Entry, MessageQueue
from .rerun_log import RerunLog

_QUEUE_BYTES = 32 * 1024 * 1024
_ESSENTIAL = (
    "bodies",
    "held_wrenches",
    "operations",
    "events",
)  # what later messages can't do without


class RerunSink:
    """Feeds a RerunLog; when it can't follow, the oldest messages are dropped and counted."""

    def __init__(self, log: RerunLog) -> None:
        self._log = log
        self._queue = MessageQueue(_QUEUE_BYTES, "drop_oldest")
        self._keys: list[tuple[str, str | None]] = []
        self._ids: dict[tuple[str, str | None], int] = {}
        self.error: str | None = None
        self._thread = threading.Thread(target=self._run, name="rerun_log", daemon=True)
        self._thread.start()

    def write(self, messages: list[tuple[str, str | None, int, bytes]]) -> None:
        """(content, body, time in ns, message), in the order of the log."""
        entries = []
        for content, body, time_ns, data in messages:
            key = (content, body)
            if key not in self._ids:
                self._keys.append(key)
                self._ids[key] = len(self._keys) - 1
                if content in _ESSENTIAL:
                    self._queue.essential.add(self._ids[key])
            entries.append(Entry(self._ids[key], time_ns, 0, data))
        self._queue.put(entries)

    @property
    def dropped(self) -> int:
        return self._queue.dropped

    def end(self) -> None:
        """What was given before is still written; anything later is passed over."""
        self._queue.close()

    def close(self) -> None:
        self._queue.close()
        self._thread.join()

    def _run(self) -> None:
        try:
            while True:
                closed = self._queue.closed
                for topic, time_ns, _, data in self._queue.take(0.05):
                    self._log.feed(*self._keys[topic], time_ns, data)
                if closed:
                    self._log.close()
                    return
        except Exception as error:
            # The bag is the archive; a view that breaks must not take the run with it.
            self.error = f"the Rerun view stopped: {error}"
            self._queue.close()
