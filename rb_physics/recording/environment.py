"""Versions and machine of a run: what a repetition compares first."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from pathlib import Path

import numpy as np


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
