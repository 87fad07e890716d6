"""Mass, centre of mass and inertia of a body from what is given of them and its shape."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, checks
from .errors import SceneError

Array = NDArray[np.float64]

_STATIC_ONLY = (_core.HalfSpace, _core.TriangleMesh, _core.HeightField)


def mass_properties(
    name: str,
    shape: Any,
    type: str,
    mass: float | None,
    density: float | None,
    inertia: ArrayLike | None,
    center_of_mass: ArrayLike | None,
) -> tuple[float, Array, Array]:
    """(mass, centre of mass, inertia); mass 0 for bodies that have none.

    Arguments as in `World.add_body`. Raises SceneError.
    """
    com = None
    if center_of_mass is not None:
        com = checks.vector(name, "center_of_mass", center_of_mass, unit="m")
    if mass is not None:
        checks.number(name, "mass", mass, 0.0, above=True, unit="kg")
    if density is not None:
        checks.number(name, "density", density, 0.0, above=True, unit="kg/m³")
    matrix = None if inertia is None else checks.inertia(name, inertia)
    if type != "dynamic":
        return 0.0, np.zeros(3) if com is None else com, np.zeros((3, 3))
    if isinstance(shape, _STATIC_ONLY):
        raise SceneError.about(
            name,
            "type",
            type,
            f"'static' for a {_core.shape_name(shape)}"
            " (for a dynamic body take a convex hull or a compound)",
        )
    if (mass is None) == (density is None):
        given = "neither" if mass is None else "both"
        raise SceneError(
            f"body {name!r}: {given} of mass and density given; a dynamic body needs exactly one",
            body=name,
            field="mass",
        )
    if isinstance(shape, _core.Particle):
        if mass is None:
            raise SceneError(
                f"body {name!r}: density is {density!r}; a particle has no volume, give its mass",
                body=name,
                field="density",
            )
        if com is not None or matrix is not None:
            field = "center_of_mass" if com is not None else "inertia"
            raise SceneError(
                f"body {name!r}: a particle has no {field}; leave it out", body=name, field=field
            )
        return float(mass), np.zeros(3), np.zeros((3, 3))
    volume, shape_com, unit_inertia = _core.unit_density_mass(shape)
    total = float(mass) if mass is not None else float(density) * volume  # type: ignore[arg-type]
    with np.errstate(over="ignore", invalid="ignore"):  # said below
        shape_inertia = unit_inertia * (total / volume)
        if com is None:
            com = shape_com
        elif matrix is None:
            # The given centre of mass is not the shape's: the shape's inertia, seen from there.
            d = com - shape_com
            shape_inertia = shape_inertia + total * (d @ d * np.eye(3) - np.outer(d, d))
    result = shape_inertia if matrix is None else matrix
    moments = result.diagonal()
    if not (1e-90 < total < 1e90 and moments.min() > 1e-150 and moments.max() < 1e150):
        raise SceneError(
            f"body {name!r}: mass {total:g} kg and moments of inertia {moments.tolist()} kg m² are"
            " too small or too large to compute with; mass may be 1e-90 to 1e90 kg, moments 1e-150"
            " to 1e150 kg m²",
            body=name,
            field="mass",
        )
    return total, com, result
