from __future__ import annotations

import ctypes
import hashlib
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from .penetration import axes_of
from .scene import Ball, Block, Hull, Scene

SOURCE = Path(__file__).with_name("ode_shim.c")


def library() -> ctypes.CDLL:
    """The shim, compiled once per version of its source; needs a C compiler and libode-dev."""
    mark = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]
    built = Path(__file__).resolve().parents[2] / "build" / "benchmarks" / f"ode_shim_{mark}.so"
    if not built.exists():
        built.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=built.parent) as folder:
            fresh = Path(folder) / "shim.so"
            subprocess.run(
                ["cc", "-O2", "-shared", "-fPIC", "-o", str(fresh), str(SOURCE), "-lode", "-lm"],
                check=True,
                capture_output=True,
                text=True,
            )
            fresh.rename(built)
    return ctypes.CDLL(str(built))


class Ode:
    """dWorldQuickStep at its defaults, up to 8 points per pair, joint feedback off. Planes, boxes, balls
    and convex hulls are its own geoms."""

    name = "ODE quick"
    precision = "f64"
    quick = 1

    def __init__(self, scene: Scene) -> None:
        self.lib = library()
        lib, double = self.lib, ctypes.c_double
        lib.start.argtypes = [double, double, double, ctypes.c_int]
        lib.start(scene.dt, scene.friction, scene.restitution, self.quick)
        lib.plane.argtypes = [double] * 4
        for plane in scene.planes:
            lib.plane(*plane.normal, plane.offset)
        pointer = np.ctypeslib.ndpointer(np.float64, flags="C")
        lib.body.argtypes = [ctypes.c_int, pointer, ctypes.c_int, double, pointer, pointer]
        lib.body.argtypes += [pointer, pointer, ctypes.c_int]
        whole = np.ctypeslib.ndpointer(np.uint32, flags="C")
        lib.hull.argtypes = [pointer, ctypes.c_int, whole]
        self.keep: list[tuple] = []
        for item in scene.items:
            if isinstance(item.shape, Ball):
                kind, numbers = 0, np.array([item.shape.radius])
            elif isinstance(item.shape, Block):
                kind, numbers = 1, np.array(item.shape.half)
            else:
                kind, numbers = 2, self.hull(item.shape)
            lib.body(
                kind,
                np.ascontiguousarray(numbers, float).ravel(),
                len(numbers),
                item.mass,
                item.mass * np.asarray(item.shape.principal_inertia, float),
                np.array(item.position, float),
                np.array(item.orientation, float),
                np.array(item.velocity, float),
                int(item.kinematic),
            )
        self.count = len(scene.items)
        lib.poses.argtypes = [pointer, pointer]
        lib.push.argtypes = [double] * 3
        self.step_once = lib.step_once

    def hull(self, shape: Hull) -> np.ndarray:
        """The vertices; the faces, in planes and polygons, are handed over."""
        vertices = np.array(shape.vertices)
        planes: list[np.ndarray] = []
        polygons: list[int] = []
        for normal in axes_of(shape).normals:
            for n in (normal, -normal):
                height = vertices @ n
                on = np.flatnonzero(height > height.max() - 1e-9)
                if len(on) < 3:
                    continue
                middle = vertices[on].mean(0)
                u = vertices[on[0]] - middle
                v = np.cross(n, u)
                angles = np.arctan2((vertices[on] - middle) @ v, (vertices[on] - middle) @ u)
                planes.append(np.append(n, height.max()))
                polygons += [len(on), *on[np.argsort(angles)].tolist()]
        key = (np.concatenate(planes), np.array(polygons, np.uint32), vertices)
        self.keep.append(key)  # ODE only points at them
        self.lib.hull(key[0], len(planes), key[1])
        return vertices

    @staticmethod
    def version() -> str:
        return "libode 0.16"

    def step(self, count: int) -> None:
        self.lib.step(count)

    def push(self, force: np.ndarray) -> None:
        self.lib.push(*force)

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        x, q = np.empty((self.count, 3)), np.empty((self.count, 4))
        self.lib.poses(x, q)
        return x, q


class OdeExact(Ode):
    """dWorldStep: the direct solver."""

    name = "ODE exact"
    quick = 0
