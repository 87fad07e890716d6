"""Versions and machine of a run, which a repetition compares first, and what else is noted of it."""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from .operations import plain


def environment() -> dict[str, str]:
    """Versions and machine: what a repetition compares first."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        own = version("rb_physics")
    except PackageNotFoundError:
        own = "source tree"
    return {
        "rb_physics": own,
        "build": _build(),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cpu": _cpu(),
    }


def notes_of_run(world: Any, scene: Any, node_name: str, format_version: int) -> dict[str, str]:
    """What is noted in every file and in metadata.yaml."""
    settings = {k: plain(v) for k, v in asdict(world.settings).items()}
    return {
        "format_version": str(format_version),
        **environment(),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "node_name": node_name,
        "scene": getattr(scene, "name", ""),
        "dt": repr(float(world.settings.dt)),
        "settings": json.dumps(settings),
        "seed": "none: nothing is random",
        "first_step": str(world.step_count),
    }


@cache
def _build() -> str:
    """Tells builds of the compiled core apart, whatever their version."""
    from .. import _core

    try:
        return hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()[:12]
    except (OSError, TypeError):  # a frozen or zipped application
        return "unknown"


def _cpu() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
