"""Where a damaged recording has lost messages: between which steps."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import NamedTuple


class LostSpan(NamedTuple):
    """Messages are lost that came after one of step `after` and before one of step `before`."""

    after: int
    before: int | None  # None: up to the end of the recording


class LostSpans:
    """Collects them while damage and whole messages come by in the order of the log."""

    def __init__(self) -> None:
        self.found: list[LostSpan] = []
        self._last = 0  # step of the last whole message
        self._open = False

    def damage(self) -> None:
        """Something is lost here."""
        self._open = True

    def message(self, step: int) -> None:
        """A whole message."""
        if self._open:
            self.found.append(LostSpan(self._last, step))
            self._open = False
        self._last = step

    def end(self) -> None:
        """No more messages."""
        if self._open:
            self.found.append(LostSpan(self._last, None))


def to_json(spans: Sequence[LostSpan]) -> str:
    """As `recover` notes them."""
    return json.dumps([list(span) for span in spans])


def from_json(text: str) -> list[LostSpan]:
    """Raises ValueError for text that `to_json` doesn't write."""
    try:
        spans = [LostSpan(*row) for row in json.loads(text)]
    except TypeError as error:
        raise ValueError(f"the noted gaps are damaged: {error}") from None
    for span in spans:
        if type(span.after) is not int or type(span.before) not in (int, type(None)):
            raise ValueError(f"the noted gaps are damaged: {list(span)}")
    return spans


def merged(spans: Sequence[LostSpan]) -> list[LostSpan]:
    """In order, those that touch or overlap as one; those that go up to the end left out."""
    result: list[LostSpan] = []
    for after, before in sorted((s.after, s.before) for s in spans if s.before is not None):
        if result and after <= (result[-1].before or 0):
            result[-1] = LostSpan(result[-1].after, max(before, result[-1].before or 0))
        else:
            result.append(LostSpan(after, before))
    return result
