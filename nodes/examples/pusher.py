"""Pushes one body with a constant wrench during a span of simulation time.

Publishes WrenchStamped on `topic` at `rate` from simulation time `start` for `duration` seconds;
afterwards the simulator lets go by itself (wrench_timeout).
"""

from __future__ import annotations

from geometry_msgs.msg import Wrench, WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from .running import follow_sim_time, number, run, vector


class Pusher(Node):
    """See the module's text; parameters topic, frame, force (N), torque (N m), start, duration (s), rate."""

    def __init__(self) -> None:
        super().__init__("pusher")
        topic = self.declare_parameter("topic", "/sim_node/bodies/ball/wrench").value
        self._frame = self.declare_parameter("frame", "world").value
        self._wrench = Wrench(
            force=vector(self, "force", [10.0, 0.0, 0.0]),
            torque=vector(self, "torque", [0.0, 0.0, 0.0]),
        )
        self._start = number(self, "start", 0.0)
        self._duration = number(self, "duration", 1.0)
        rate = number(self, "rate", 50.0, above=0.0)
        follow_sim_time(self)
        self._publisher = self.create_publisher(WrenchStamped, topic, 10)
        self._pushing = False
        # A wall timer: the simulation may be paused or run at any speed.
        self.create_timer(1.0 / rate, self._push, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _push(self) -> None:
        now = self.get_clock().now()
        time = now.nanoseconds * 1e-9
        pushing = self._start <= time < self._start + self._duration and time > 0.0
        if pushing != self._pushing:
            self._pushing = pushing
            verb = "begins to push" if pushing else "stops pushing"
            self.get_logger().info(f"{verb} {self._publisher.topic_name} at {time:.2f} s")
        if pushing:
            message = WrenchStamped(wrench=self._wrench)
            message.header.stamp = now.to_msg()
            message.header.frame_id = self._frame
            self._publisher.publish(message)


def main() -> None:
    """Entry point."""
    run(Pusher)


if __name__ == "__main__":
    main()
