"""Rigid bodies in contact: wrenches you can trust, runs you can repeat.

    import rb_physics as rb

    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace(normal=(0, 0, 1), offset=0.0), type="static", name="ground")
    box = world.add_body(rb.Box(half_extents=(0.1, 0.1, 0.1)), mass=1.0, position=(0, 0, 1))
    world.step(1000)
    print(box.position, box.contact_wrench)

SI units, right-handed, z up; quaternions are x, y, z, w. The normal of a contact points from body
B to body A. Needs numpy only; scene files, recording and Rerun load their libraries on use.
"""

from __future__ import annotations

from typing import Any

from ._core import (
    Box,
    Capsule,
    Compound,
    ConvexHull,
    Cylinder,
    HalfSpace,
    HeightField,
    Particle,
    Sphere,
    Stats,
    TriangleMesh,
    math,
)
from .batch import Batch
from .body import Body
from .contact import ContactKind, ContactState
from .errors import DivergedError, SceneError
from .queries import (
    ContactKinematics,
    Distance,
    contact_kinematics,
    distance,
    find_contacts,
    test_intersection,
    time_of_impact,
)
from .settings import Settings
from .world import RayHit, World

__all__ = [
    "Batch",
    "Body",
    "Box",
    "Capsule",
    "Compound",
    "ContactKind",
    "ContactKinematics",
    "ContactState",
    "ConvexHull",
    "Cylinder",
    "Distance",
    "DivergedError",
    "HalfSpace",
    "HeightField",
    "Particle",
    "RayHit",
    "Scene",
    "SceneError",
    "Settings",
    "Sphere",
    "Stats",
    "TriangleMesh",
    "World",
    "contact_kinematics",
    "distance",
    "find_contacts",
    "load_scene",
    "math",
    "test_intersection",
    "time_of_impact",
]

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    # Scene files need PyYAML and a schema validator: loaded on first use.
    if name in ("Scene", "load_scene"):
        from . import scene

        return getattr(scene, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
