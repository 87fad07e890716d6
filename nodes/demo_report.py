"""What the demo hears over topics, and the sentences it makes of it."""

from __future__ import annotations

import json
import math
import time
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

import rb_physics as rb
from rb_physics.recording.decoders import decode_clock, decode_point_cloud, decode_pose_array

GROUND, BALL = "ground", "ball"
BEFORE_TOLERANCE = 1e-6  # relative; the standing tower carries its weight in every step
AFTER_TOLERANCE = 1e-3  # relative; the heap has come to rest, up to a last rocking


class Report:
    """Listens to contacts, poses, /clock and diagnostics of sim_node."""

    def __init__(self, node: Node, tower: str) -> None:
        world = rb.load_scene("demo").build()
        self._tower = [body.name for body in world.bodies if body.name.startswith(tower)]
        gravity = float(np.linalg.norm(world.settings.gravity))
        self._weight = gravity * sum(world[name].mass for name in self._tower)
        self._ball_weight = gravity * world[BALL].mass
        self._names: list[str] = []
        # time s, vertical force of the ground on the tower's boxes, and on the ball
        self._support: list[tuple[float, float, float]] = []
        self._hit: float | None = None
        self._first_poses: Any = None
        self._last_poses: Any = None
        self._values: dict[str, dict[str, str]] = {}
        self._wall: list[float] = []
        self._node = node
        self.time = 0.0  # of the last /clock, s
        self.finished = False
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        listen = node.create_subscription
        self._subscriptions = [
            listen(String, "/sim_node/body_names", self._read_names, latched),
            listen(Clock, "/clock", self._read_clock, 100, raw=True),
            listen(PointCloud2, "/sim_node/contacts", self._read_contacts, 100, raw=True),
            listen(PoseArray, "/sim_node/poses", self._read_poses, 100, raw=True),
            listen(DiagnosticArray, "/sim_node/diagnostics", self._read_diagnostics, 10),
        ]

    @property
    def connected(self) -> bool:
        """All topics have their publisher, and the names of the bodies have come."""
        return bool(self._names) and all(
            subscription.get_publisher_count() > 0 for subscription in self._subscriptions
        )

    def _read_names(self, message: String) -> None:
        self._names = json.loads(message.data)

    def _read_clock(self, data: bytes) -> None:
        self.time = decode_clock(data) * 1e-9
        self._wall = [self._wall[0] if self._wall else time.monotonic(), time.monotonic()]

    def _read_poses(self, data: bytes) -> None:
        _, _, poses = decode_pose_array(data)
        if self._first_poses is None:
            self._first_poses = poses
        self._last_poses = poses

    def _read_contacts(self, data: bytes) -> None:
        time_ns, _, contacts = decode_point_cloud(data)
        tower = ball = 0.0
        for row in contacts:
            a, b = self._names[row["body_a"]], self._names[row["body_b"]]
            if a in self._tower and b == GROUND:
                tower += float(row["fz"])
            elif a == BALL and b == GROUND:
                ball += float(row["fz"])
            elif self._hit is None and BALL in (a, b) and (a in self._tower or b in self._tower):
                self._hit = time_ns * 1e-9
        self._support.append((time_ns * 1e-9, tower, ball))

    def _read_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._values[status.name] = {item.key: item.value for item in status.values}
        stamp = message.header.stamp
        self.finished = stamp.sec + stamp.nanosec * 1e-9 > self.time - 0.5

    def _mean_support(self, begin: float, end: float) -> tuple[float, float]:
        """Mean force of the ground on the tower, and on the ball, N."""
        forces = [(tower, ball) for when, tower, ball in self._support if begin < when <= end]
        if not forces:
            return math.nan, math.nan
        tower, ball = np.mean(forces, axis=0)
        return float(tower), float(ball)

    def tell(self, push: float, end: float) -> list[str]:
        """Print what happened; returns what was not as it must be."""
        failures = []
        before, _ = self._mean_support(push - 1.0, push)
        heap, heap_weight = (
            sum(self._mean_support(end - 0.5, end)),
            self._weight + self._ball_weight,
        )
        print(f"tower, m g:               {self._weight:10.4f} N")
        print(f"force under it:           {before:10.4f} N   mean over the second before the push")
        if not abs(before / self._weight - 1) <= BEFORE_TOLERANCE:
            failures.append("the force under the standing tower is not its weight")
        if self._hit is None:
            failures.append("the ball did not reach the tower")
        else:
            print(f"the ball hits it at:      {self._hit:10.2f} s   simulated time")
        print(f"boxes and ball, m g:      {heap_weight:10.4f} N")
        print(f"force under them:         {heap:10.4f} N   mean over the last half second")
        if not abs(heap / heap_weight - 1) <= AFTER_TOLERANCE:
            failures.append("the force under the heap of boxes and ball is not its weight")
        moved = self._moved()
        print(f"boxes moved by:           {moved:10.2f} m   at most")
        if not moved > 0.05:
            failures.append("the ball did not move the tower")
        return failures + self._tell_node()

    def _moved(self) -> float:
        if self._first_poses is None:
            return 0.0
        rows = [self._names.index(name) for name in self._tower]
        way = (self._last_poses - self._first_poses)[rows, :3]
        return float(np.linalg.norm(way, axis=1).max())

    def _tell_node(self) -> list[str]:
        failures = []
        timing = self._values.get("sim_node: timing", {})
        inputs = self._values.get("sim_node: inputs", {})
        log = self._values.get("sim_node: log", {})
        if len(self._wall) == 2 and self._wall[1] > self._wall[0]:
            factor = self.time / (self._wall[1] - self._wall[0])
            print(
                f"real-time factor:         {factor:10.3f}     lost steps {timing.get('lost_steps')}"
            )
        dropped = {"messages in": inputs.get("dropped"), "log": log.get("dropped")}
        listed = ", ".join(f"{name} {count}" for name, count in dropped.items())
        print(
            f"wrenches accepted:        {inputs.get('accepted', '0'):>10}     refused {inputs.get('refused')}"
        )
        print(f"dropped:                  {listed}")
        if any(count != "0" for count in dropped.values()):
            failures.append(f"messages were dropped: {listed}")
        if inputs.get("refused") != "0" or int(inputs.get("accepted", "0")) == 0:
            failures.append("the pusher's wrenches were not all accepted")
        return failures
