"""Pushes a body from the keyboard: w/s along x, a/d along y, r/f along z, q/e turn about z.

Each key press pushes for the simulator's wrench_timeout; holding a key repeats it. Ctrl-C ends.
"""

from __future__ import annotations

import select
import sys
import termios
import tty

import rclpy
from geometry_msgs.msg import Vector3, WrenchStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from .running import number

KEYS = {  # key -> direction of force, direction of torque
    "w": ((1, 0, 0), (0, 0, 0)),
    "s": ((-1, 0, 0), (0, 0, 0)),
    "a": ((0, 1, 0), (0, 0, 0)),
    "d": ((0, -1, 0), (0, 0, 0)),
    "r": ((0, 0, 1), (0, 0, 0)),
    "f": ((0, 0, -1), (0, 0, 0)),
    "q": ((0, 0, 0), (0, 0, 1)),
    "e": ((0, 0, 0), (0, 0, -1)),
}


class KeyboardWrench(Node):
    """Parameters topic, frame, force (N), torque (N m)."""

    def __init__(self) -> None:
        super().__init__("keyboard_wrench")
        topic = self.declare_parameter("topic", "/sim_node/bodies/ball/wrench").value
        self._frame = self.declare_parameter("frame", "world").value
        self._force = number(self, "force", 10.0)
        self._torque = number(self, "torque", 1.0)
        self._publisher = self.create_publisher(WrenchStamped, topic, 10)

    def press(self, key: str) -> None:
        """Publish the wrench of a key; other keys do nothing."""
        if key not in KEYS:
            return
        force, torque = KEYS[key]
        message = WrenchStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = self._frame
        message.wrench.force = _scaled(force, self._force)
        message.wrench.torque = _scaled(torque, self._torque)
        self._publisher.publish(message)


def _scaled(direction: tuple[int, int, int], size: float) -> Vector3:
    x, y, z = (size * value for value in direction)
    return Vector3(x=x, y=y, z=z)


def main() -> None:
    """Entry point."""
    if not sys.stdin.isatty():
        raise SystemExit("keyboard_wrench reads keys from a terminal: start it in one")
    rclpy.init()
    node = KeyboardWrench()
    print(__doc__)
    settings = termios.tcgetattr(sys.stdin)
    try:
        tty.setcbreak(sys.stdin.fileno())
        while rclpy.ok():
            if select.select([sys.stdin], [], [], 0.05)[0]:
                node.press(sys.stdin.read(1))
            rclpy.spin_once(node, timeout_sec=0.0)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:  # rcl's: the signal came just before spin_once looked
        if rclpy.ok():
            raise
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
