"""A thruster: a force along the axes of a frame of the body, which turns with the body.

The frame is one declared in the scene (NAME/FRAME); the force acts at its origin.
"""

from __future__ import annotations

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from .running import follow_sim_time, number, run, vector


class Thruster(Node):
    """Parameters topic, frame, thrust, on_for and off_for (simulated seconds), rate."""

    def __init__(self) -> None:
        super().__init__("thruster")
        topic = self.declare_parameter("topic", "/sim_node/bodies/crate/wrench").value
        self._frame = self.declare_parameter("frame", "crate/thruster").value
        self._thrust = vector(self, "thrust", [0.0, 0.0, 5.0])
        self._on_for = number(self, "on_for", 1.0)
        self._off_for = number(self, "off_for", 1.0)
        rate = number(self, "rate", 100.0, above=0.0)
        follow_sim_time(self)
        self._publisher = self.create_publisher(WrenchStamped, topic, 10)
        self.create_timer(1.0 / rate, self._fire, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _fire(self) -> None:
        now = self.get_clock().now()
        if (now.nanoseconds * 1e-9) % (self._on_for + self._off_for) >= self._on_for:
            return
        message = WrenchStamped()
        message.header.stamp = now.to_msg()
        message.header.frame_id = self._frame
        message.wrench.force = self._thrust
        self._publisher.publish(message)


def main() -> None:
    """Entry point."""
    run(Thruster)


if __name__ == "__main__":
    main()
