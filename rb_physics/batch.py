"""Many variations of one world, stepped in one call: parameter studies, learning, sampling."""

from __future__ import annotations

from collections.abc import Callable, Iterator

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
        n: number of variations, ≥ 1.
        threads: threads that share the variations, the caller's included; None: as many as
            ``world.settings.threads``.

    Raises:
        SceneError: ``n`` or ``threads`` is not a whole number ≥ 1.
    """

    def __init__(self, world: World, n: int, threads: int | None = None) -> None:
        if threads is None:
            threads = world.settings.threads
        for name, value in (("n", n), ("threads", threads)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise SceneError.about(None, name, value, "a whole number ≥ 1")
        self._worlds = tuple(world.copy(threads=1) for _ in range(n))
        super().__init__(list(self._worlds), threads)

    def __len__(self) -> int:
        return len(self._worlds)

    def __getitem__(self, index: int) -> World:
        """Variation ``index``; negative ones count from the end."""
        return self._worlds[index]

    def __iter__(self) -> Iterator[World]:
        return iter(self._worlds)

    def __repr__(self) -> str:
        return f"<Batch: {len(self)} variations of {len(self._worlds[0])} bodies>"

    def step(self, n: int = 1) -> None:
        """``n`` steps of every variation.

        Raises:
            DivergedError: of the first variation that diverged, its number in ``variation``; it keeps
                its last good state, the others have made all their steps.
        """
        trouble = self._step(n)
        if trouble is None:
            return
        index, step, row = trouble
        name = self._worlds[index].bodies[row].name if row >= 0 else ""
        raise DivergedError(
            f"variation {index}, step {step}: the state of body {name!r} stopped being finite; the "
            "variation holds its last good state: look for huge forces, masses or speeds",
            step=step,
            body=name,
            variation=index,
        )

    @property
    def positions(self) -> Array:
        """(n, N, 3) m, origins of the body frames. Setting them keeps the velocities."""
        return self._read(self._positions)

    @positions.setter
    def positions(self, value: ArrayLike) -> None:
        self._write("positions", value, self._set_positions)

    @property
    def orientations(self) -> Array:
        """(n, N, 4) unit quaternions x y z w. Setting them keeps positions and velocities."""
        return self._read(self._orientations)

    @orientations.setter
    def orientations(self, value: ArrayLike) -> None:
        q = _numbers("orientations", value)
        norms = np.linalg.norm(q, axis=-1) if q.ndim == 3 else np.ones(1)
        if (np.abs(norms - 1.0) > 1e-3).any():
            worst = float(norms.flat[np.argmax(np.abs(norms - 1.0))])
            raise SceneError(
                f"orientations must be unit quaternions x y z w; one has the length {worst:.6g}",
                field="orientations",
            )
        self._write("orientations", q, self._set_orientations)

    @property
    def linear_velocities(self) -> Array:
        """(n, N, 3) m/s, of the centres of mass. Settable; static bodies stay at rest."""
        return self._read(self._linear_velocities)

    @linear_velocities.setter
    def linear_velocities(self, value: ArrayLike) -> None:
        self._write("linear_velocities", value, self._set_linear_velocities)

    @property
    def angular_velocities(self) -> Array:
        """(n, N, 3) rad/s. Settable; static bodies stay at rest."""
        return self._read(self._angular_velocities)

    @angular_velocities.setter
    def angular_velocities(self, value: ArrayLike) -> None:
        self._write("angular_velocities", value, self._set_angular_velocities)

    @property
    def contact_wrenches(self) -> Array:
        """(n, N, 2, 3) contact force (N) and torque about the centre of mass (N m), world axes, mean
        over the last step."""
        flat = self._read(self._contact_wrenches)
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
        f = _numbers("forces", forces)
        t = np.zeros_like(f) if torques is None else _numbers("torques", torques)
        if t.shape != f.shape:
            raise SceneError.about(None, "torques", t.shape, f"an array of shape {f.shape}")
        if duration is not None:
            checks.number(None, "duration", duration, 0.0, unit="s")
        seconds = -1.0 if duration is None else float(duration)
        self._write("forces", f, lambda values: self._apply_wrenches(values, t, seconds))

    @staticmethod
    def _read(getter: Callable[[], Array]) -> Array:
        try:
            return getter()
        except ValueError as error:
            raise SceneError(f"batch: {error}") from None

    @staticmethod
    def _write(field: str, value: ArrayLike, setter: Callable[[Array], None]) -> None:
        try:
            setter(_numbers(field, value))
        except SceneError:
            raise
        except ValueError as error:
            raise SceneError(f"batch: {field}: {error}", field=field) from None


def _numbers(field: str, value: ArrayLike) -> Array:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError.about(None, field, type(value).__name__, "an array of numbers") from None
    if not np.isfinite(array).all():
        raise SceneError.about(None, field, "NaN or infinity", "finite numbers")
    return array
