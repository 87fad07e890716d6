"""Which numbers of a message can be a state."""

import math
from collections.abc import Iterable

GREATEST = 1e20  # m, m/s, rad/s: more makes a state that can't be stepped, and stops the run


def not_allowed(values: Iterable[float]) -> str | None:
    """The rule that the numbers of a message break, or None."""
    values = tuple(values)
    if not all(map(math.isfinite, values)):
        return "must be finite"
    if max(map(abs, values), default=0.0) > GREATEST:
        return f"must be {GREATEST:g} at most"
    return None
