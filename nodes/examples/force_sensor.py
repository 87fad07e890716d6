"""Reads a body's contact wrench and checks that it carries a given weight.

Over each second of simulation time it adds up force times interval, which is exactly the contact
impulse (each message is the mean over its interval), and compares the mean with `expected`.
"""

from __future__ import annotations

import math

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node

from .running import number, run


class ForceSensor(Node):
    """Parameters topic, expected (N), tolerance (N), span (s)."""

    def __init__(self) -> None:
        super().__init__("force_sensor")
        topic = self.declare_parameter("topic", "/sim_node/bodies/crate/contact_wrench").value
        self._expected = number(self, "expected", 9.81)
        self._tolerance = number(self, "tolerance", 0.05)
        self._span = number(self, "span", 1.0, above=0.0)
        self._impulse = [0.0, 0.0, 0.0]
        self._begin = self._last = math.nan
        self.create_subscription(WrenchStamped, topic, self._read, 100)

    def _read(self, message: WrenchStamped) -> None:
        time = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        if not self._last < time:  # first message, or the simulation was reset
            self._begin = self._last = time
            self._impulse = [0.0, 0.0, 0.0]
            return
        interval, self._last = time - self._last, time
        force = message.wrench.force
        for axis, value in enumerate((force.x, force.y, force.z)):
            self._impulse[axis] += value * interval
        if time - self._begin < self._span - 1e-9:
            return
        mean = math.sqrt(sum(value * value for value in self._impulse)) / (time - self._begin)
        verdict = "as expected" if abs(mean - self._expected) <= self._tolerance else "NOT expected"
        self.get_logger().info(
            f"mean contact force {mean:.4f} N over {time - self._begin:.2f} s, "
            f"expected {self._expected:.4f} N: {verdict}"
        )
        self._begin, self._impulse = time, [0.0, 0.0, 0.0]


def main() -> None:
    """Entry point."""
    run(ForceSensor)


if __name__ == "__main__":
    main()
