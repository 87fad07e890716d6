"""Many variations of one world, stepped in one call: parameter studies, learning, sampling."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, checks
from .errors import DivergedError, SceneError
from .world import World

Array = NDArray[np.float64]


class Batch(_core.Batch):
    """``n`` independent copies of a world, each in its state, shared out to threads.

    A variation is a `World` like any other, ``batch[i]``: change its bodies, frictions or wrenches as
    usual, or all variations at once through the arrays, (n, N, ...) with N bodies. Every variation
    has the same bits as if it were stepped alone, for any number of threads.

    Example::

        batch = rb.Batch(world, 64, threads=2)
        for i, variation in enumerate(batch):
            variation["box"].friction = 0.1 + 0.01 * i
        batch.step(1000)
        reached = batch.positions[:, world["box"].row, 0]

    Args:
        world: what all variations start as; it stays as it is.
        n: number of variations, 1 to 1000000.
        threads: threads that share the variations, the caller's included; None: as many as
            ``world.settings.threads``.

    Raises:
        SceneError: ``world`` is no world; ``n`` or ``threads`` is not a whole number ≥ 1.
    """

    __slots__ = ("_worlds",)

    def __init__(self, world: World, n: int, threads: int | None = None) -> None:
        if not isinstance(world, World):
            raise SceneError.about(None, "world", world, "an rb.World")
        n = checks.whole_number("n", n, 1, 1_000_000)
        shared = world.settings.threads if threads is None else threads
        shared = checks.whole_number("threads", shared, 1, 1024)
        self._worlds = tuple(world.copy(threads=1) for _ in range(n))
        super().__init__(list(self._worlds), shared)

    def __setattr__(self, name: str, value: Any) -> None:
        checks.settable(self, name, "it is what the last step did")
        super().__setattr__(name, value)

    def __len__(self) -> int:
        return len(self._worlds)

    def __getitem__(self, index: int) -> World:
        """Variation ``index``; negative ones count from the end. Raises IndexError."""
        row = checks.whole_number("variation", index, -(2**31))
        if not -len(self) <= row < len(self):
            raise IndexError(f"there is no variation {row}; the batch has {len(self)}")
        return self._worlds[row]

    def __iter__(self) -> Iterator[World]:
        return iter(self._worlds)

    def __repr__(self) -> str:
        return f"<Batch: {len(self)} variations of {len(self._worlds[0])} bodies>"

    def step(self, n: int = 1) -> None:
        """``n`` steps of every variation.

        Raises:
            SceneError: ``n`` is not a whole number ≥ 0.
            DivergedError: of the first variation that diverged, its number in ``variation``; it keeps
                its last good state, the others have made all their steps.
        """
        trouble = self._step(checks.whole_number("n", n, 0, 2**63 - 1))
        if trouble is None:
            return
        index, step, row = trouble
        name = self._worlds[index].bodies[row].name if row >= 0 else ""
        raise DivergedError(
            f"variation {index}, step {step}: the state of body {name!r} stopped being finite, grew beyond 1e30 or turned by more than 1e4 rad; the "
            "variation holds its last good state: look for huge forces, masses or speeds",
            step=step,
            body=name,
            variation=index,
        )

    @property
    def positions(self) -> Array:
        """(n, N, 3) m, origins of the body frames. Setting them keeps the velocities. What is read is
        a copy that can't be written to, here and below."""
        return self._read(self._positions)

    @positions.setter
    def positions(self, value: ArrayLike) -> None:
        self._write("positions", value, 3, self._set_positions)

    @property
    def orientations(self) -> Array:
        """(n, N, 4) unit quaternions x y z w. Setting them keeps positions and velocities."""
        return self._read(self._orientations)

    @orientations.setter
    def orientations(self, value: ArrayLike) -> None:
        q = self._numbers("orientations", value, 4)
        with np.errstate(over="ignore"):  # infinite lengths are off, too
            off = np.abs(np.linalg.norm(q, axis=-1) - 1.0)
        if (off > checks.QUATERNION_NORM).any():
            i, row = np.unravel_index(np.argmax(off), off.shape)
            raise SceneError.about(
                self._body(int(i), int(row)),
                f"orientations[{i}, {row}]",
                q[i, row],
                f"one of unit quaternions x y z w; its length is off by {off[i, row]:.6g}",
            )
        self._write("orientations", q, 4, self._set_orientations)

    @property
    def linear_velocities(self) -> Array:
        """(n, N, 3) m/s, of the centres of mass. Settable; static bodies stay at rest."""
        return self._read(self._linear_velocities)

    @linear_velocities.setter
    def linear_velocities(self, value: ArrayLike) -> None:
        self._write("linear_velocities", value, 3, self._set_linear_velocities)

    @property
    def angular_velocities(self) -> Array:
        """(n, N, 3) rad/s. Settable; static bodies stay at rest."""
        return self._read(self._angular_velocities)

    @angular_velocities.setter
    def angular_velocities(self, value: ArrayLike) -> None:
        self._write("angular_velocities", value, 3, self._set_angular_velocities)

    @property
    def contact_wrenches(self) -> Array:
        """(n, N, 2, 3) contact force (N) and torque about the centre of mass (N m), world axes, mean
        over the last step."""
        self._bodies()
        flat = self._contact_wrenches()
        return flat.reshape(*flat.shape[:2], 2, 3)

    @property
    def state_hashes(self) -> NDArray[np.uint64]:
        """(n,) 64-bit hashes over everything that influences the future."""
        return self._state_hashes()

    def apply_wrenches(
        self, forces: ArrayLike, torques: ArrayLike | None = None, duration: float | None = None
    ) -> None:
        """Forces (n, N, 3) in N on the centres of mass and torques (n, N, 3) in N m, world axes, from
        the next step on; each replaces the one its body had. Bodies that are not dynamic are passed
        over. ``duration`` as in `Body.apply_wrench`: None until replaced, 0 one step.

        Raises:
            SceneError: a wrong shape, NaN or infinity, a negative duration.
        """
        f = self._numbers("forces", forces, 3)
        t = np.zeros_like(f) if torques is None else self._numbers("torques", torques, 3)
        if duration is not None:
            checks.number(None, "duration", duration, 0.0, unit="s")
        seconds = -1.0 if duration is None else float(duration)
        self._apply_wrenches(f, t, seconds)

    def _read(self, getter: Callable[[], Array]) -> Array:
        self._bodies()
        array = getter()
        array.flags.writeable = False
        return array

    def _write(
        self, field: str, value: ArrayLike, width: int, setter: Callable[[Array], None]
    ) -> None:
        setter(self._numbers(field, value, width))

    def _bodies(self) -> int:
        """How many bodies each variation has."""
        counts = {len(variation) for variation in self._worlds}
        if len(counts) > 1:
            raise SceneError(
                f"the variations have different numbers of bodies ({min(counts)} to"
                f" {max(counts)}): no array holds them; read and set them one by one, batch[i]"
            )
        return counts.pop()

    def _body(self, variation: int, row: int) -> str:
        return self._worlds[variation].bodies[row].name

    def _numbers(self, field: str, value: ArrayLike, width: int) -> Array:
        shape = (len(self), self._bodies(), width)
        array = checks.real_numbers(value)
        if array is None or array.shape != shape:
            raise SceneError.about(
                None,
                field,
                value,
                f"an array of numbers of shape {shape}: variations, bodies, axes",
            )
        if not np.isfinite(array).all():
            i, row = np.argwhere(~np.isfinite(array))[0, :2]
            # Refuses it in the words of a single one.
            checks.vector(
                self._body(int(i), int(row)), f"{field}[{i}, {row}]", array[i, row], width
            )
        return array
