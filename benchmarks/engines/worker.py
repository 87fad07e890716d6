"""The process of one engine: builds a scene, makes steps, times them, gives poses back."""

from __future__ import annotations

import os
import resource
import sys
import time
from importlib import import_module
from multiprocessing.connection import Connection

import numpy as np

from .engine import Engine
from .scenes import scenes

ENGINES = {
    "rb_physics": ("engine_rb_physics", "RbPhysics"),
    "MuJoCo": ("engine_mujoco", "MuJoCo"),
    "PyBullet": ("engine_pybullet", "PyBullet"),
    "DART": ("engine_dart", "Dart"),
    "PhysX": ("engine_physx", "PhysX"),
    "ODE quick": ("engine_ode", "Ode"),
    "ODE exact": ("engine_ode", "OdeExact"),
}
MEMORY = 8 << 30  # bytes of address space: a dense matrix of a heap would take the machine down


def engine_class(name: str) -> type[Engine]:
    """Raises ImportError or OSError when the engine is not installed."""
    module, attribute = ENGINES[name]
    return getattr(import_module(f".{module}", __package__), attribute)


def control_step(engine: Engine, count: int) -> None:
    force = np.array([0.5, 0.0, 0.0])
    for _ in range(count):
        engine.push(force)
        engine.step_once()
        engine.poses()


def call_step(engine: Engine, count: int) -> None:
    step = engine.step_once
    for _ in range(count):
        step()


def serve(pipe: Connection, name: str, core: int) -> None:
    """Answers ("build", scene), ("step", count) with seconds, ("poses",); errors as text."""
    os.sched_setaffinity(0, {core})
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[variable] = "1"
    sys.stdout.flush()
    for stream in (1, 2):  # engines greet and complain
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    engine, advance = None, None
    while True:
        what, *arguments = pipe.recv()
        try:
            if what == "version":
                kind = engine_class(name)
                pipe.send((None, (kind.precision, kind.version())))
            elif what == "build":
                scene = scenes()[arguments[0]]
                engine = engine_class(name)(scene)
                if scene.from_python:
                    advance = control_step
                else:
                    advance = call_step if scene.call_only else type(engine).step
                pipe.send((None, None))
            elif what == "step":
                start = time.perf_counter()
                advance(engine, arguments[0])
                pipe.send((None, time.perf_counter() - start))
            elif what == "poses":
                pipe.send((None, engine.poses()))
        except Exception as error:
            pipe.send((f"{type(error).__name__}: {error}"[:200], None))
