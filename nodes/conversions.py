"""From the words of topics.yaml to the types of rclpy."""

from __future__ import annotations

import importlib
from typing import Any

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from rb_physics.recording.topics import Qos


def message_class(type_name: str) -> Any:
    """The Python class of e.g. ``geometry_msgs/msg/PoseArray``.

    Raises ImportError when the package of the type is not installed.
    """
    package, _, name = type_name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except ModuleNotFoundError as error:
        raise ImportError(f"{type_name} needs the ROS package {package}") from error


def qos_profile(qos: Qos) -> QoSProfile:
    """The same quality of service for rclpy."""
    return QoSProfile(
        history=HistoryPolicy[qos.history.upper()],
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )
