"""What the examples share: a clean start and end, and reading vectors from parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import rclpy
from geometry_msgs.msg import Vector3
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..parameters import check_names


def run(make_node: Callable[[], Node]) -> None:
    """Spin a node until SIGINT or SIGTERM; a ValueError of its constructor is its error message."""
    rclpy.init()
    try:
        node = make_node()
        check_names(node)
        rclpy.spin(node)
    except ValueError as error:
        raise SystemExit(str(error)) from None
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:  # rcl's: the signal came just before spin looked
        if rclpy.ok():
            raise
    finally:
        rclpy.try_shutdown()


def follow_sim_time(node: Node) -> None:
    """Let the node's clock follow /clock, unless the user decided otherwise."""
    if "use_sim_time" not in node._parameter_overrides:
        node.set_parameters([Parameter("use_sim_time", Parameter.Type.BOOL, True)])


def number(node: Node, name: str, default: float, above: float | None = None) -> float:
    """Declare a parameter that is a number, whole or not, and return it. Raises ValueError."""
    value = _declared(node, name, default)
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not good or not math.isfinite(value) or (above is not None and value <= above):
        rule = "a number" if above is None else f"a number above {above:g}"
        raise ValueError(f"parameter {name} is {value!r}, but must be {rule}")
    return float(value)


def numbers(node: Node, name: str, default: list[float]) -> list[float]:
    """The same for as many numbers as the default has. Raises ValueError."""
    value = _declared(node, name, default)
    given = [] if isinstance(value, (str, bool, int, float)) else list(value)
    if len(given) != len(default) or not all(
        isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in given
    ):
        raise ValueError(
            f"parameter {name} is {given or value!r}, but must be {len(default)} numbers"
        )
    return [float(v) for v in given]


def vector(node: Node, name: str, default: list[float]) -> Vector3:
    """The same as a Vector3."""
    x, y, z = numbers(node, name, default)
    return Vector3(x=x, y=y, z=z)


def _declared(node: Node, name: str, default: Any) -> Any:
    """Its value, of whatever type: that is judged here, with a sentence."""
    return node.declare_parameter(name, default, ParameterDescriptor(dynamic_typing=True)).value
