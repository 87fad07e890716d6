"""How a node starts, and what it says when it can't."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any


class StartError(RuntimeError):
    """The node can't start; the text is one sentence that says what to do."""


def import_rclpy() -> Any:
    """rclpy, or a StartError that tells what is missing."""
    chosen = os.environ.get("RMW_IMPLEMENTATION", "")
    # A middleware that isn't there ends the process inside rcl: a process of its own tries it.
    if chosen not in ("", "rmw_fastrtps_cpp") and not _starts_with_rclpy():
        raise StartError(
            f"the ROS middleware {chosen}, named by the environment variable RMW_IMPLEMENTATION, "
            "is not installed for this Python: unset the variable (rmw_fastrtps_cpp comes with "
            "pip install ros-jazzy-rmw-fastrtps-cpp) or install that middleware"
        )
    try:
        import rclpy
        from rclpy.impl.implementation_singleton import rclpy_implementation  # noqa: F401
    except ImportError as error:
        if "rmw" in str(error):
            raise StartError(
                f"the ROS middleware is missing ({error}): pip install ros-jazzy-rmw-fastrtps-cpp, "
                "or source your ROS 2 installation"
            ) from None
        raise StartError(
            f"ROS 2 is missing ({error}): pip install ros-jazzy-rclpy ros-jazzy-common-interfaces "
            "ros-jazzy-rmw-fastrtps-cpp, or source your ROS 2 installation"
        ) from None
    return rclpy


def _starts_with_rclpy() -> bool:
    program = "from rclpy.impl.implementation_singleton import rclpy_implementation"
    tried = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False)
    return tried.returncode == 0


def one_line(error: BaseException) -> str:
    """The text of an exception without line breaks."""
    return " ".join(str(error).split()) or type(error).__name__
