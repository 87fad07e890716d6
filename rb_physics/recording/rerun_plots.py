"""Curves of the Rerun view: energy, momentum, contact forces, the solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .outputs import TOTALS
from .palette import FORCE, KINEMATIC, RGBA
from .rerun_batch import Batch, time_index

_FLOOR = 1e-18  # residual and penetration are drawn as logarithms no smaller than that
_SERIES: dict[str, tuple[str, RGBA]] = {
    "energy/kinetic": ("kinetic [J]", (89, 161, 79, 255)),
    "energy/potential": ("potential [J]", (78, 121, 167, 255)),
    "energy/total": ("total [J]", (205, 205, 210, 255)),
    "contacts/points": ("contact points", (118, 183, 178, 255)),
    "momentum/linear": ("linear [kg m/s]", (78, 121, 167, 255)),
    "momentum/angular": ("angular about the origin [kg m²/s]", KINEMATIC),
    "solver/residual": ("log10 of residual", (176, 122, 161, 255)),
    "solver/penetration": ("log10 of deepest penetration [m]", FORCE),
}


class Plots:
    """Everything below `plots/`."""

    def __init__(self, recording: Any, bodies: Sequence[tuple[str, RGBA]], batch: int) -> None:
        """`bodies`: names and colours of those whose contact force gets a curve."""
        import rerun

        self._rr, self._rec = rerun, recording
        for entity, (name, color) in _SERIES.items():
            self._style(entity, name, color)
        for name, color in bodies:
            self._style(f"contact_force/{name}", f"{name} [N]", color)
        self._totals: Batch[bytes] = Batch(batch, self._send_totals)
        self._wrenches = {name: Batch[bytes](batch, self._sender(name)) for name, _ in bodies}

    def _style(self, entity: str, name: str, color: RGBA) -> None:
        style = self._rr.SeriesLines(names=name, colors=[color])
        self._rec.log(f"plots/{entity}", style, static=True)

    def add_totals(self, time_ns: int, data: bytes, stepped: bool = True) -> None:
        """One message of ~/totals; before the first step it tells nothing of contacts and solver."""
        if stepped:
            self._totals.add(time_ns, data)
        else:
            self._send_energy(time_index([time_ns]), _columns([data]))

    def add_wrench(self, time_ns: int, body: str, data: bytes) -> None:
        """One contact wrench; passed over when the body has no curve."""
        if body in self._wrenches:
            self._wrenches[body].add(time_ns, data)

    def flush(self) -> None:
        self._totals.flush()
        for batch in self._wrenches.values():
            batch.flush()

    def _sender(self, body: str) -> Any:
        def send(index: Any, samples: list[bytes]) -> None:
            wrenches = decoders.stack_doubles(samples, _wrench, stamped=True)
            forces = np.linalg.norm(wrenches[:, :3], axis=1)
            # A weight at rest is a level line: the viewer would fill the plot with its last bits.
            self._send(f"contact_force/{body}", index, forces.astype(np.float32))

        return send

    def _send(self, entity: str, index: Any, values: NDArray) -> None:
        columns = self._rr.Scalars.columns(scalars=values)
        self._rec.send_columns(f"plots/{entity}", indexes=[index], columns=columns)

    def _send_totals(self, index: Any, samples: list[bytes]) -> None:
        of = _columns(samples)
        self._send_energy(index, of)
        self._send("contacts/points", index, of["contacts"])
        for entity, name in (("residual", "residual"), ("penetration", "max_penetration")):
            self._send(f"solver/{entity}", index, np.log10(np.maximum(of[name], _FLOOR)))

    def _send_energy(self, index: Any, of: dict[str, NDArray]) -> None:
        self._send("energy/kinetic", index, of["kinetic_energy"])
        self._send("energy/potential", index, of["potential_energy"])
        self._send("energy/total", index, of["kinetic_energy"] + of["potential_energy"])
        for entity, axes in (("linear", ("px", "py", "pz")), ("angular", ("Lx", "Ly", "Lz"))):
            size = np.sqrt(sum(of[axis] ** 2 for axis in axes))
            self._send(f"momentum/{entity}", index, size)


def _columns(samples: list[bytes]) -> dict[str, NDArray]:
    table = decoders.stack_doubles(samples, _totals, stamped=False)
    return {name: table[:, column] for column, name in enumerate(TOTALS)}


def _wrench(data: bytes) -> NDArray:
    return np.array(decoders.decode_wrench_stamped(data).values)


def _totals(data: bytes) -> NDArray:
    return decoders.decode_multi_array(data, "f8")[1].reshape(-1)
