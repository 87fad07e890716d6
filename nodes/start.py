"""How a node starts and ends, and what it says when it can't."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

# That end a node; the last comes when its terminal is closed, unless nohup keeps it away.
SIGNALS = tuple(
    number
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN
)


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


def check_arguments(arguments: Sequence[str] | None) -> None:
    """Raises StartError for what ROS would pass over without a word."""
    left, of_ros = [], False
    for word in sys.argv[1:] if arguments is None else arguments:
        if word in ("--ros-args", "--"):
            of_ros = word == "--ros-args"
        elif not of_ros:
            left.append(word)
    if left:
        raise StartError(
            f"{left[0]} is no argument of a node: parameters are given as --ros-args -p NAME:=VALUE, and "
            "docs/ros.md lists them"
        )


def ignore_signals() -> None:
    """At the very end: Python gives the handlers up before its process is over, and a second Ctrl-C
    would kill what has ended well."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def one_line(error: BaseException) -> str:
    """The text of an exception without line breaks."""
    return " ".join(str(error).split()) or type(error).__name__
