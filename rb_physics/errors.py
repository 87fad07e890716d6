"""What rb_physics raises when an input is wrong or a simulation cannot go on."""

from __future__ import annotations

import math


class SceneError(ValueError):
    """A scene, body, shape or setting that cannot be simulated as given.

    The message is one sentence that names the body, the field, its value and what is allowed.
    ``body`` and ``field`` repeat the first two for programs (None when they don't apply);
    ``field`` is spelled as in scene files, e.g. ``"mass"`` or ``"shape.radius"``. Errors found in
    a scene file start with ``FILE:LINE: ``.
    """

    def __init__(self, message: str, *, body: str | None = None, field: str | None = None) -> None:
        super().__init__(message)
        self.body = body
        self.field = field

    @classmethod
    def about(cls, body: str | None, field: str, value: object, allowed: str) -> SceneError:
        """The usual sentence: ``body 'crate': mass is -1.0; it must be a finite number > 0 (kg)``.

        ``allowed`` completes "it must be …".
        """
        where = f"body {body!r}: " if body is not None else ""
        return cls(
            f"{where}{field} is {_shown(value)}; it must be {allowed}", body=body, field=field
        )


class DivergedError(RuntimeError):
    """The state became non-finite; the world still holds the last good state.

    Attributes:
        step: number of the step that failed, counted from the start of the world.
        body: name of the first body concerned.
        variation: its number in a `Batch`, else None.
    """

    def __init__(self, message: str, *, step: int, body: str, variation: int | None = None) -> None:
        super().__init__(message)
        self.step = step
        self.body = body
        self.variation = variation


def _shown(value: object) -> str:
    """The value as a message can show it: one line, at most 120 characters."""
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple) and all(isinstance(n, int) for n in shape):
        if math.prod(shape) > 16:
            return f"an array of shape {shape}"
        value = value.tolist()  # type: ignore[attr-defined]
    try:
        text = " ".join(repr(value).split())
    except Exception:  # whatever a foreign __repr__ raises; ints of more than 4300 digits do
        return f"an object of type {type(value).__name__}"
    return text if len(text) <= 120 else f"{text[:117]}..."
