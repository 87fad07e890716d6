"""The choices a user has about the physics (``rb.Settings``)."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass, fields, replace
from typing import Any

from . import _core
from .errors import SceneError

_STEPPERS = {"fixed": _core.Stepper.FIXED, "event": _core.Stepper.EVENT}
_FREE_MOTION = {"exact": _core.FreeMotion.EXACT, "rk4": _core.FreeMotion.RK4}
_IMPACT_LAWS = {name.lower(): value for name, value in _core.ImpactLaw.__members__.items()}
_COMBINE = {name.lower(): value for name, value in _core.Combine.__members__.items()}


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Choices that hold for the life of a world. Raises `SceneError` for values that are not allowed.

    Attributes:
        gravity: (3,) m/s², world axes.
        dt: s, > 0.
        stepper: "fixed" (constant dt) or "event" (from contact time to contact time).
        impact_law: "sequential", "simultaneous" or "reflections" (S12 to S14).
        threads: worker threads; the result does not depend on it.
        sleeping: let islands sleep that were slower than 1 µm/s for 0.5 s: they cost nothing, their
            contacts and wrenches stay as they were. A change of state, surface or wrench, a moving
            neighbour within reach, and a body added or removed wake them.
        tolerance: relative residual asked of the contact solver.
        max_work: bound on one contact solve, in visits of one contact (about 0.1 µs); 0: none.
            When it bites, ``world.stats.capped`` and ``residual`` say so.
        max_events: contact times and stick events an island may have in one step.
        max_event_contacts: islands with more contact points take the step in one solve.
        free_motion: "exact", or "rk4" as in the notes (S6).
        friction_combine: "geometric_mean", "mean", "min", "max" or "product".
        restitution_combine: the same choices.
        restitution_threshold: m/s; a slower rebound counts as rest. None: acceleration times dt / 2.
        contact_margin: m, ≥ 0; contacts are looked for this much farther than needed.
    """

    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    dt: float = 1e-3
    stepper: str = "fixed"
    impact_law: str = "simultaneous"
    threads: int = 1
    sleeping: bool = False
    tolerance: float = 1e-13
    max_work: int = 0
    max_events: int = 16
    max_event_contacts: int = 16
    free_motion: str = "exact"
    friction_combine: str = "geometric_mean"
    restitution_combine: str = "max"
    restitution_threshold: float | None = None
    contact_margin: float = 0.0

    def __post_init__(self) -> None:
        gravity = self.gravity
        try:
            values = tuple(float(v) for v in gravity)
        except (TypeError, ValueError):
            values = ()
        if len(values) != 3 or not all(map(math.isfinite, values)):
            raise SceneError.about(None, "gravity", gravity, "three finite numbers (m/s²)")
        object.__setattr__(self, "gravity", values)
        _require_number("dt", self.dt, lambda v: v > 0, "a finite number > 0 (s)")
        _require_number(
            "tolerance", self.tolerance, lambda v: 0 < v < 1, "a number between 0 and 1"
        )
        _require_number("contact_margin", self.contact_margin, lambda v: v >= 0, "≥ 0 (m)")
        if self.restitution_threshold is not None:
            _require_number(
                "restitution_threshold", self.restitution_threshold, lambda v: v >= 0, "≥ 0 (m/s)"
            )
        for name, least in (
            ("threads", 1),
            ("max_work", 0),
            ("max_events", 0),
            ("max_event_contacts", 0),
        ):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise SceneError.about(None, name, value, f"a whole number ≥ {least}")
        if not isinstance(self.sleeping, bool):
            raise SceneError.about(None, "sleeping", self.sleeping, "True or False")
        _require_choice("stepper", self.stepper, _STEPPERS)
        _require_choice("impact_law", self.impact_law, _IMPACT_LAWS)
        _require_choice("free_motion", self.free_motion, _FREE_MOTION)
        _require_choice("friction_combine", self.friction_combine, _COMBINE)
        _require_choice("restitution_combine", self.restitution_combine, _COMBINE)

    @classmethod
    def from_keywords(cls, base: Settings | None, keywords: dict[str, Any]) -> Settings:
        """``base`` (or the defaults) with ``keywords`` replaced; unknown names get a suggestion."""
        known = [f.name for f in fields(cls)]
        for name in keywords:
            if name not in known:
                close = difflib.get_close_matches(name, known, n=1)
                hint = (
                    f"; did you mean {close[0]!r}?" if close else f"; known are {', '.join(known)}"
                )
                raise SceneError(f"unknown setting {name!r}{hint}", field=name)
        return replace(base, **keywords) if base is not None else cls(**keywords)

    def to_core(self) -> _core.CoreSettings:
        """The same for the C++ core."""
        core = _core.CoreSettings()
        for f in fields(self):
            value = getattr(self, f.name)
            table = _TABLES.get(f.name)
            setattr(core, f.name, table[value] if table else value)
        return core


_TABLES: dict[str, dict[str, Any]] = {
    "stepper": _STEPPERS,
    "impact_law": _IMPACT_LAWS,
    "free_motion": _FREE_MOTION,
    "friction_combine": _COMBINE,
    "restitution_combine": _COMBINE,
}


def _require_number(name: str, value: Any, allowed: Any, words: str) -> None:
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not good or not math.isfinite(value) or not allowed(value):
        raise SceneError.about(None, name, value, words)


def _require_choice(name: str, value: Any, table: dict[str, Any]) -> None:
    if not isinstance(value, str) or value not in table:
        raise SceneError.about(None, name, value, "one of " + ", ".join(repr(k) for k in table))
