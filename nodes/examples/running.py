"""What the examples share: a clean start and end, and reading vectors from parameters."""

from __future__ import annotations

from collections.abc import Callable

import rclpy
from geometry_msgs.msg import Vector3
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


def run(make_node: Callable[[], Node]) -> None:
    """Spin a node until SIGINT or SIGTERM; a ValueError of its constructor is its error message."""
    rclpy.init()
    try:
        node = make_node()
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


def vector(node: Node, name: str, default: list[float], description: str) -> Vector3:
    """Declare a parameter of three numbers and return it as a Vector3."""
    from rcl_interfaces.msg import ParameterDescriptor

    value = node.declare_parameter(
        name, default, ParameterDescriptor(description=description)
    ).value
    if len(value) != 3:
        raise ValueError(f"parameter {name} is {list(value)}, but must be three numbers")
    return Vector3(x=float(value[0]), y=float(value[1]), z=float(value[2]))
