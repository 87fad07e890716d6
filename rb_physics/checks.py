"""Checks of values that come from outside: what is wrong is said with body, field, value and rule."""

from __future__ import annotations

import difflib
import math
import operator
import re
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import SceneError

Array = NDArray[np.float64]

_DOUBLE = np.dtype(np.float64)
_PLAIN = frozenset((float, int))
_EXACT = 2**53  # whole numbers below are doubles
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
QUATERNION_NORM = 1e-3  # |q| may be off by this much and is then normalised
_GREATEST_INERTIA = 1e90  # kg m²
_INERTIA_TRIANGLE = 1e-9  # relative excess of the largest moment over the sum of the others


def name(value: Any, what: str, taken: Any = (), body: str | None = None) -> str:
    """A body or frame name: it becomes part of topics and frames."""
    if not isinstance(value, str) or not _NAME.match(value) or value == "world":
        raise SceneError.about(
            body,
            f"{what} name",
            value,
            "a letter followed by letters, digits and underscores, and not 'world'"
            " (it becomes a topic and a frame)",
        )
    if value in taken:
        raise SceneError(f"{what} name {value!r} is already taken; names are unique", field="name")
    return value


def real_numbers(value: Any) -> Array | None:
    """A new array of doubles; None for text, truth values, complex numbers, dates and ragged lists,
    which numpy would make numbers of."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iufO":
            return None
        if array.dtype.itemsize > 8:  # long doubles overflow
            with np.errstate(over="ignore"):
                return array.astype(np.float64)
        return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        return None


def vector(body: str | None, field: str, value: Any, size: int = 3, unit: str = "") -> Array:
    """``size`` finite numbers."""
    # Most are arrays of doubles or tuples of plain numbers: a third of the time.
    array: Array | None
    if type(value) is np.ndarray and value.dtype is _DOUBLE:
        array = value.copy()
    elif type(value) is tuple and _PLAIN.issuperset(map(type, value)):
        try:
            array = np.array(value, _DOUBLE)
        except OverflowError:
            array = None
    else:
        array = real_numbers(value)
    # For a few numbers quicker than numpy's own test.
    if array is None or array.shape != (size,) or not all(map(math.isfinite, array.tolist())):
        words = f"{size} finite numbers" + (f" ({unit})" if unit else "")
        raise SceneError.about(body, field, value, words)
    return array


def whole_number(
    field: str, value: Any, least: int, most: int = 2**31 - 1, body: str | None = None
) -> int:
    """A whole number within [least, most]; a float is none, however whole."""
    good = not isinstance(value, (bool, np.bool_)) and hasattr(value, "__index__")
    try:
        number = operator.index(value) if good else least - 1
    except TypeError:  # an array of several
        number = least - 1
    if not least <= number <= most:
        rule = f"≥ {least}" if number < least else f"from {least} to {most}"
        raise SceneError.about(body, field, value, f"a whole number {rule}")
    return number


def flag(field: str, value: Any) -> bool:
    """True or False; what is merely true-like is refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError.about(None, field, value, "True or False")
    return bool(value)


def choice(body: str | None, field: str, value: Any, allowed: Collection[str]) -> str:
    """One of the words."""
    if not isinstance(value, str) or value not in allowed:
        words = [repr(word) for word in allowed]
        close = difflib.get_close_matches(value, allowed, n=1) if isinstance(value, str) else []
        hint = f" (did you mean {close[0]!r}?)" if close else ""
        raise SceneError.about(body, field, value, f"{', '.join(words[:-1])} or {words[-1]}{hint}")
    return value


def suggestion(name: str, known: Iterable[str]) -> str:
    """``; did you mean 'friction'?``, or what there is."""
    words = list(known)
    close = difflib.get_close_matches(name, words, n=1)
    return f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(words)}"


def settable(owner: Any, name: str, reason: str) -> None:
    """Raises AttributeError where an assignment to an attribute would be lost: one that is not there,
    with a suggestion, or one that can only be read, for the `reason`."""
    found = getattr(type(owner), name, None)
    what = type(owner).__name__
    if found is None:
        known = [k for k in dir(owner) if not k.startswith("_")]
        raise AttributeError(f"{what} has no attribute {name!r}{suggestion(name, known)}")
    if isinstance(found, property) and found.fset is None:
        raise AttributeError(f"{what}.{name} can't be set: {reason}")
    if callable(found) and not name.startswith("_"):
        raise AttributeError(f"{what}.{name} is a method; call it")


def quaternion(body: str | None, field: str, value: Any) -> Array:
    """A unit quaternion x y z w; normalised when its length is within 1e-3 of 1."""
    q = vector(body, field, value, 4, "x y z w")
    norm = math.sqrt(float(q @ q))
    if abs(norm - 1.0) > QUATERNION_NORM:
        raise SceneError.about(
            body, field, value, f"a unit quaternion x y z w (its length is {norm:.6g})"
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
    if type(value) is float or (type(value) is int and abs(value) < _EXACT):
        good = math.isfinite(value)
    else:
        array = real_numbers(value)
        good = array is not None and array.ndim == 0 and math.isfinite(array)
    if good and least is not None:
        good = bool(value > least if above else value >= least)
    if good and most is not None:
        good = bool(value <= most)
    if not good:
        words = "a finite number"
        if least is not None:
            words += f" {'>' if above else '≥'} {least:g}"
        if most is not None:
            words += f"{' and' if least is not None else ''} ≤ {most:g}"
        raise SceneError.about(body, field, value, words + (f" ({unit})" if unit else ""))
    return float(value)


def inertia(body: str | None, value: Any) -> Array:
    """(3,) principal moments or a symmetric (3, 3) matrix, kg m², body axes, about the centre of mass."""
    array = real_numbers(value)
    if array is None or array.shape not in ((3,), (3, 3)) or not np.isfinite(array).all():
        raise SceneError.about(
            body, "inertia", value, "3 principal moments or a 3 x 3 matrix (kg m²)"
        )
    if np.abs(array).max() > _GREATEST_INERTIA:
        raise SceneError.about(body, "inertia", value, f"at most {_GREATEST_INERTIA:g} kg m²")
    matrix = np.diag(array) if array.shape == (3,) else array
    skewness = np.abs(matrix - matrix.T)
    if skewness.max() > 1e-9 * np.abs(matrix).max():
        row, column = np.unravel_index(np.argmax(skewness), (3, 3))
        raise SceneError.about(
            body,
            "inertia",
            value,
            f"symmetric ([{row}, {column}] is {float(matrix[row, column])!r},"
            f" [{column}, {row}] is {float(matrix[column, row])!r})",
        )
    matrix = 0.5 * (matrix + matrix.T)
    moments = np.linalg.eigvalsh(matrix) if array.shape == (3, 3) else np.sort(array)
    least, middle, most = (float(m) for m in moments)
    if least <= 0:
        raise SceneError.about(
            body, "inertia", value, f"positive definite (its least principal moment is {least!r})"
        )
    if most > (least + middle) * (1 + _INERTIA_TRIANGLE):
        raise SceneError.about(
            body,
            "inertia",
            value,
            "that of a real body: its largest principal moment may not exceed the sum of the other"
            f" two ({most!r} > {least!r} + {middle!r})",
        )
    return matrix
