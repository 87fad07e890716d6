"""The worst step of an interval: what is sent now and then still tells of every step."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

Worst = tuple[float, float, int]  # residual, max_penetration (m), contacts


class WorstSteps:
    """Largest residual, penetration and number of contacts since each reader took them last."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._since: dict[Hashable, Worst] = {}

    def open(self, reader: Hashable) -> None:
        """From now on for this reader, if it isn't known yet."""
        self._drain()
        self._since.setdefault(reader, (0.0, 0.0, 0))

    def take(self, reader: Hashable) -> Worst:
        """Of the steps since the reader took last."""
        self._drain()
        worst, self._since[reader] = self._since[reader], (0.0, 0.0, 0)
        return worst

    def _drain(self) -> None:
        new = self._world.drain_worst()
        for reader, (residual, penetration, contacts) in self._since.items():
            self._since[reader] = (
                max(residual, new[0]), max(penetration, new[1]), max(contacts, new[2])
            )  # fmt: skip
