"""What is kept of every step of a case."""

from __future__ import annotations

import rb_physics as rb


class Watch:
    """Steps a world and keeps the worst of what `world.stats` says."""

    def __init__(self, world: rb.World) -> None:
        self.world = world
        self.residual = 0.0
        self.energy_gain = 0.0

    def step(self) -> None:
        self.world.step()
        self.residual = max(self.residual, self.world.stats.residual)
        self.energy_gain = max(self.energy_gain, self.world.stats.energy_error)

    def report(self, **errors: float) -> dict[str, float]:
        return {**errors, "residual": self.residual, "energy gain": self.energy_gain}
