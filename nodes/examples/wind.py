"""Wind on all bodies: a force on each, in world axes at its centre of mass, with gusts.

The bodies come from ~/body_names, so nothing has to be configured; static ones have no wrench
topic and are left out because nobody listens there.
"""

from __future__ import annotations

import json
import math

from geometry_msgs.msg import Vector3, WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from .running import follow_sim_time, number, run, vector


class Wind(Node):
    """Parameters simulator, force (N on each body, world axes), gust (relative), gust_period, rate."""

    def __init__(self) -> None:
        super().__init__("wind")
        self._simulator = self.declare_parameter("simulator", "/sim_node").value
        self._force = vector(self, "force", [0.5, 0.0, 0.0])
        self._gust = number(self, "gust", 0.3)
        self._period = number(self, "gust_period", 4.0, above=0.0)
        rate = number(self, "rate", 20.0, above=0.0)
        follow_sim_time(self)
        self._bodies: list[Publisher] = []
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, f"{self._simulator}/body_names", self._named, latched)
        self.create_timer(1.0 / rate, self._blow, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _named(self, message: String) -> None:
        for publisher in self._bodies:
            self.destroy_publisher(publisher)
        self._bodies = [
            self.create_publisher(WrenchStamped, f"{self._simulator}/bodies/{name}/wrench", 10)
            for name in json.loads(message.data)
        ]

    def _blow(self) -> None:
        now = self.get_clock().now()
        strength = 1.0 + self._gust * math.sin(2 * math.pi * now.nanoseconds * 1e-9 / self._period)
        message = WrenchStamped()
        message.header.stamp = now.to_msg()
        message.header.frame_id = "world"
        force = self._force
        message.wrench.force = Vector3(
            x=strength * force.x, y=strength * force.y, z=strength * force.z
        )
        for publisher in self._bodies:
            if publisher.get_subscription_count() > 0:
                publisher.publish(message)


def main() -> None:
    """Entry point."""
    run(Wind)


if __name__ == "__main__":
    main()
