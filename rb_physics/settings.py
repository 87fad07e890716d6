"""The choices a user has about the physics (``rb.Settings``)."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass, fields, replace
from typing import Any

import numpy as np

from . import _core, checks
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
        threads: worker threads, 1 to 1024; the result does not depend on it.
        sleeping: let islands sleep that were slower than 1 µm/s for 0.5 s: they cost nothing, their
            contacts and wrenches stay as they were. A change of state, surface or wrench, a moving
            neighbour within reach, and a body added or removed wake them.
        tolerance: relative residual asked of the contact solver.
        max_work: bound on one contact solve, in visits of one contact (about 0.1 µs); 0: none.
            When it bites, ``world.stats.capped`` and ``residual`` say so.
        max_events: contact times and stick events an island may have in one step (eight times as many
            where something moves fast enough to pass through what it meets). After that the rest of
            the step is one solve; what is that fast waits at its next contact instead.
            ``world.stats.capped`` and ``waits`` say so.
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
        def put(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        gravity = checks.real_numbers(self.gravity)
        if gravity is None or gravity.shape != (3,) or not np.isfinite(gravity).all():
            raise SceneError.about(None, "gravity", self.gravity, "three finite numbers (m/s²)")
        put("gravity", tuple(gravity.tolist()))
        put("dt", checks.number(None, "dt", self.dt, 0.0, above=True, unit="s"))
        if self.dt < 1e-100:  # impulses over it would overflow
            raise SceneError.about(None, "dt", self.dt, "at least 1e-100 s")
        tolerance = checks.number(None, "tolerance", self.tolerance)
        if not 0.0 < tolerance < 1.0:
            raise SceneError.about(None, "tolerance", self.tolerance, "a number between 0 and 1")
        put("tolerance", tolerance)
        for name, unit in (("contact_margin", "m"), ("restitution_threshold", "m/s")):
            value = getattr(self, name)
            if value is not None or name == "contact_margin":
                put(name, checks.number(None, name, value, 0.0, unit=unit))
        put("threads", checks.whole_number("threads", self.threads, 1, 1024))
        put("max_work", checks.whole_number("max_work", self.max_work, 0, 2**62))
        for name in ("max_events", "max_event_contacts"):
            put(name, checks.whole_number(name, getattr(self, name), 0))
        put("sleeping", checks.flag("sleeping", self.sleeping))
        for name, table in _TABLES.items():
            checks.choice(None, name, getattr(self, name), table)

    @classmethod
    def from_keywords(cls, base: Settings | None, keywords: dict[str, Any]) -> Settings:
        """``base`` (or the defaults) with ``keywords`` replaced; unknown names get a suggestion."""
        if base is not None and not isinstance(base, Settings):
            raise SceneError.about(
                None, "settings", base, "rb.Settings(...); single fields can be keywords"
            )
        known = [f.name for f in fields(cls)]
        for name in keywords:
            if name not in known:
                raise SceneError(
                    f"unknown setting {name!r}{checks.suggestion(name, known)}", field=name
                )
        return replace(base, **keywords) if base is not None else cls(**keywords)

    def to_core(self) -> _core.CoreSettings:
        """The same for the C++ core."""
        core = _core.CoreSettings()
        for f in fields(self):
            value = getattr(self, f.name)
            table = _TABLES.get(f.name)
            setattr(core, f.name, table[value] if table else value)
        return core


def _refuse(self: Settings, name: str, value: object) -> None:
    known = [f.name for f in fields(self)]
    if name not in known:
        raise AttributeError(f"Settings has no attribute {name!r}{checks.suggestion(name, known)}")
    raise FrozenInstanceError(
        f"Settings.{name} can't be set: settings hold for the life of a world; give a new world"
        f" others, e.g. rb.World(settings, {name}=...)"
    )


Settings.__setattr__ = _refuse  # type: ignore[assignment,method-assign]

_TABLES: dict[str, dict[str, Any]] = {
    "stepper": _STEPPERS,
    "impact_law": _IMPACT_LAWS,
    "free_motion": _FREE_MOTION,
    "friction_combine": _COMBINE,
    "restitution_combine": _COMBINE,
}
