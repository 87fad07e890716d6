"""Queries between bodies (S7): do they intersect, where, how far apart, when do they meet."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core, checks
from .body import Body
from .errors import SceneError

if TYPE_CHECKING:
    from .world import World


class Distance(NamedTuple):
    """Nearest points of two bodies, world axes."""

    distance: float
    """m; negative when they overlap: minus the depth."""
    point_a: NDArray[np.float64]
    """(3,) m, on a."""
    point_b: NDArray[np.float64]
    """(3,) m, on b."""
    normal: NDArray[np.float64]
    """(3,) unit, from b to a."""


class ContactKinematics(NamedTuple):
    """Separation of a contact and its first two rates (S10)."""

    d: float
    """m, N . (P_A - P_B)."""
    d_dot: float
    """m/s, with the term of the turning normal."""
    d_ddot: float
    """m/s², with both extra terms."""


def test_intersection(a: Body, b: Body) -> bool:
    """True when the closed bodies share a point: the notes' test-intersection query.

    Here and below, ``a`` and ``b`` are two bodies of one world, else `SceneError`.
    """
    world = _common_world(a, b)
    return world._test_intersection(a.row, b.row)


test_intersection.__test__ = False  # type: ignore[attr-defined]  # not for pytest to collect


def find_contacts(a: Body, b: Body, margin: float = 0.0) -> NDArray[np.void]:
    """The contact set of two bodies: the notes' find-intersection query.

    Args:
        margin: m; points up to this separation are reported.

    Returns:
        Structured array (n,): body_a, body_b, point, normal (from b to a), separation, feature,
        kind.
    """
    world = _common_world(a, b)
    margin = checks.number(None, "margin", margin, 0.0, unit="m")
    return world._find_contacts(a.row, b.row, margin)


def distance(a: Body, b: Body) -> Distance:
    """Distance and nearest points; minus the penetration depth when the bodies overlap.

    The depth in a mesh or height field is that of the deepest contact, along the normal of the
    surface there: it can jump where the body's corners pass from face to face. The distance from
    outside is exact and continuous.
    """
    world = _common_world(a, b)
    return Distance(*world._distance(a.row, b.row))


def time_of_impact(a: Body, b: Body, t_max: float) -> float | None:
    """Contact time (s from now) of the two bodies, or None if they don't meet within ``t_max``.

    The motion is the unconstrained one (S6) from the present state: velocities, rotation, gravity and
    applied wrenches; contacts do not act.

    Raises:
        SceneError: the answer cannot be told: a body spins so fast or flies so far before ``t_max``
            that the work would have no end or the motion is lost in rounding. The error says up to
            which time nothing meets.
    """
    world = _common_world(a, b)
    t_max = checks.number(None, "t_max", t_max, 0.0, unit="s")
    time, converged = world._time_of_impact(a.row, b.row, t_max)
    if not converged:
        raise SceneError(
            f"time_of_impact: bodies {a.name!r} and {b.name!r} do not meet before t = {time:.9g} s; "
            f"what comes between then and t_max = {t_max:.9g} s cannot be told (too many turns near "
            "each other, or positions lost in rounding): ask for a shorter t_max, or step the world "
            "and ask again",
            field="t_max",
        )
    return time


def contact_kinematics(world: World, i: int) -> ContactKinematics:
    """d, d_dot, d_ddot of row ``i`` of ``world.contacts`` (S10), from the present state and forces.

    The accelerations are those of gravity, applied wrenches and the contact forces of the last step.

    Raises:
        SceneError: there is no such row.
    """
    if not isinstance(world, _core.World):
        raise SceneError.about(None, "world", world, "an rb.World")
    n = len(world.contacts)
    row = checks.whole_number("i", i, -(2**31))
    if not -n <= row < n:
        raise SceneError(
            f"contact row {row} does not exist; world.contacts has {n} rows", field="i"
        )
    return ContactKinematics(*world._contact_kinematics(row % n))


def _common_world(a: Body, b: Body) -> World:
    for which, body in (("a", a), ("b", b)):
        if not isinstance(body, Body):
            raise SceneError.about(None, which, body, "a body of a world: world['NAME']")
    if a.world is not b.world:
        raise SceneError(f"bodies {a.name!r} and {b.name!r} are in different worlds")
    if a is b:
        raise SceneError(f"a query needs two bodies; {a.name!r} was given twice")
    for body in (a, b):
        if type(body.shape).__name__ == "Particle" and body.type != "dynamic":
            raise SceneError(f"body {body.name!r} has no surface")
    if _is_scenery(a) and _is_scenery(b):
        raise SceneError(
            f"bodies {a.name!r} ({type(a.shape).__name__}) and {b.name!r} ({type(b.shape).__name__}) "
            "are both scenery; of two half-spaces, meshes or height fields no query tells anything: "
            "one of the bodies must have another shape"
        )
    return a.world


def _is_scenery(body: Body) -> bool:
    return type(body.shape).__name__ in ("HalfSpace", "TriangleMesh", "HeightField")


def bounding_box(body: Body) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """(lower, upper) corner (3,), m, of the box along the body's axes, in body coordinates; None for
    what has no end.
    """
    lower, upper = _core.bounding_box(body.shape, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))
    return (lower, upper) if np.isfinite([lower, upper]).all() else None
