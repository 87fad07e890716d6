"""Checks of values that come from outside: what is wrong is said with body, field, value and rule."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import SceneError

Array = NDArray[np.float64]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_QUATERNION_NORM = 1e-3  # |q| may be off by this much and is then normalised
_INERTIA_TRIANGLE = 1e-9  # relative excess of the largest moment over the sum of the others


def name(value: Any, what: str, taken: Any = ()) -> str:
    """A body or frame name: it becomes part of topics and frames."""
    if not isinstance(value, str) or not _NAME.match(value) or value == "world":
        raise SceneError.about(
            None,
            f"{what} name",
            value,
            "a letter followed by letters, digits and underscores, and not 'world'"
            " (it becomes a topic and a frame)",
        )
    if value in taken:
        raise SceneError(f"{what} name {value!r} is already taken; names are unique", field="name")
    return value


def vector(body: str | None, field: str, value: ArrayLike, size: int = 3, unit: str = "") -> Array:
    """``size`` finite numbers."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (size,) or not np.isfinite(array).all():
        words = f"{size} finite numbers" + (f" ({unit})" if unit else "")
        raise SceneError.about(body, field, _short(value), words)
    return array


def quaternion(body: str | None, field: str, value: ArrayLike) -> Array:
    """A unit quaternion x y z w; normalised when its length is within 1e-3 of 1."""
    q = vector(body, field, value, 4, "x y z w")
    norm = math.sqrt(float(q @ q))
    if abs(norm - 1.0) > _QUATERNION_NORM:
        raise SceneError.about(
            body, field, _short(value), f"a unit quaternion x y z w (its length is {norm:.6g})"
        )
    return q / norm


def number(
    body: str | None,
    field: str,
    value: Any,
    least: float | None = None,
    most: float | None = None,
    *,
    above: bool = False,
    unit: str = "",
) -> float:
    """A finite number within [least, most], or (least, most] with ``above``."""
    good = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    good = good and math.isfinite(value)
    if good and least is not None:
        good = value > least if above else value >= least
    if good and most is not None:
        good = value <= most
    if not good:
        words = "a finite number"
        if least is not None:
            words += f" {'>' if above else '≥'} {least:g}"
        if most is not None:
            words += f"{' and' if least is not None else ''} ≤ {most:g}"
        raise SceneError.about(body, field, _short(value), words + (f" ({unit})" if unit else ""))
    return float(value)


def inertia(body: str | None, value: ArrayLike) -> Array:
    """(3,) principal moments or a symmetric (3, 3) matrix, kg m², body axes, about the centre of mass."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape not in ((3,), (3, 3)) or not np.isfinite(array).all():
        raise SceneError.about(
            body, "inertia", _short(value), "3 principal moments or a 3 x 3 matrix (kg m²)"
        )
    matrix = np.diag(array) if array.shape == (3,) else array
    if np.abs(matrix - matrix.T).max() > 1e-9 * np.abs(matrix).max():
        raise SceneError.about(body, "inertia", _short(value), "symmetric")
    matrix = 0.5 * (matrix + matrix.T)
    moments = np.linalg.eigvalsh(matrix) if array.shape == (3, 3) else np.sort(array)
    if moments[0] <= 0:
        raise SceneError.about(
            body,
            "inertia",
            _short(value),
            f"positive definite (its least moment is {moments[0]:g})",
        )
    if moments[2] > (moments[0] + moments[1]) * (1 + _INERTIA_TRIANGLE):
        raise SceneError.about(
            body,
            "inertia",
            _short(value),
            "that of a real body: its largest principal moment may not exceed the sum of the other"
            f" two (they are {moments[0]:g}, {moments[1]:g}, {moments[2]:g})",
        )
    return matrix


def _short(value: Any) -> Any:
    """The value as a message can show it."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    text = repr(value)
    return value if len(text) <= 120 else text[:117] + "..."
