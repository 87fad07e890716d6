"""Holds a body at a pose against gravity and pushes: a PD controller on odometry.

Reads Odometry (pose in world, twist in the body frame), publishes WrenchStamped in frame world,
at the rate of the odometry: a closed loop through topics. The gains follow from the mass, the
inertia and two natural frequencies (critically damped).
"""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Vector3, WrenchStamped
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from rclpy.node import Node

from .running import number, numbers, run


class PoseHolder(Node):
    """Parameters body, simulator, position, orientation, mass, inertia, frequency, gravity."""

    def __init__(self) -> None:
        super().__init__("pose_holder")
        body = self.declare_parameter("body", "crate").value
        simulator = self.declare_parameter("simulator", "/sim_node").value
        self._position = np.array(numbers(self, "position", [0.0, 0.0, 1.0]))
        self._orientation = np.array(numbers(self, "orientation", [0.0, 0.0, 0.0, 1.0]))
        self._mass = number(self, "mass", 1.0, above=0.0)
        inertia = number(self, "inertia", 0.01, above=0.0)
        omega = 2 * np.pi * number(self, "frequency", 2.0, above=0.0)
        self._gravity = np.array(numbers(self, "gravity", [0.0, 0.0, -9.81]))
        self._stiffness = (self._mass * omega**2, inertia * omega**2)
        self._damping = (2 * self._mass * omega, 2 * inertia * omega)
        self._publisher = self.create_publisher(
            WrenchStamped, f"{simulator}/bodies/{body}/wrench", 10
        )
        self.create_subscription(Odometry, f"{simulator}/bodies/{body}/odom", self._control, 10)

    def _control(self, odometry: Odometry) -> None:
        p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
        linear, angular = odometry.twist.twist.linear, odometry.twist.twist.angular
        orientation = np.array([q.x, q.y, q.z, q.w])
        velocity = _turn(orientation, np.array([linear.x, linear.y, linear.z]))
        spin = _turn(orientation, np.array([angular.x, angular.y, angular.z]))
        offset = self._position - np.array([p.x, p.y, p.z])
        force = (
            self._stiffness[0] * offset - self._damping[0] * velocity - self._mass * self._gravity
        )
        torque = self._stiffness[1] * _rotation(orientation, self._orientation)
        torque = torque - self._damping[1] * spin
        message = WrenchStamped()
        message.header.stamp = odometry.header.stamp
        message.header.frame_id = "world"
        message.wrench.force = Vector3(x=force[0], y=force[1], z=force[2])
        message.wrench.torque = Vector3(x=torque[0], y=torque[1], z=torque[2])
        self._publisher.publish(message)


def _turn(q: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
    """u turned by the unit quaternion q (x, y, z, w)."""
    cross = np.cross(q[:3], u)
    return u + 2 * (q[3] * cross + np.cross(q[:3], cross))


def _rotation(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation vector (world axes, rad, small angles) that takes start to end."""
    vector = start[3] * end[:3] - end[3] * start[:3] - np.cross(end[:3], start[:3])
    scalar = end @ start
    return 2 * (vector if scalar >= 0 else -vector)


def main() -> None:
    """Entry point."""
    run(PoseHolder)


if __name__ == "__main__":
    main()
