"""What one would write first: a timer, message objects, a callback for each wrench topic.

    python -m benchmarks.plain_node SCENE SECONDS RATE PUSHED BAG

The same world and step as the node's benchmark, PoseArray and PointCloud2 every step, everything
sent written to an MCAP file. Prints one line of JSON at the end.
"""

from __future__ import annotations

import json
import sys
import time
from functools import partial
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import Pose, PoseArray, WrenchStamped
from mcap.writer import Writer
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2, PointField

import rb_physics as rb
from benchmarks.node_scenes import pushed_bodies
from rb_physics.recording.outputs import CONTACT_POINT, contact_points

POINT_TYPES = {"f4": PointField.FLOAT32, "i4": PointField.INT32, "u4": PointField.UINT32,
               "u1": PointField.UINT8}  # fmt: skip


class PlainNode(Node):
    """A world stepped by a timer."""

    def __init__(self, scene: str, rate: float, pushed: int, bag: Any) -> None:
        super().__init__("sim_node")
        self.world = rb.load_scene(scene).build()
        self._poses = self.create_publisher(PoseArray, "~/poses", 10)
        self._contacts = self.create_publisher(PointCloud2, "~/contacts", 10)
        for name in pushed_bodies(pushed):
            topic = f"~/bodies/{name}/wrench"
            self.create_subscription(WrenchStamped, topic, partial(self._push, name), 10)
        self._fields = []
        for name in CONTACT_POINT.names or ():
            kind, offset = CONTACT_POINT.fields[name][:2]  # type: ignore[index]
            count = int(np.prod(kind.shape)) if kind.shape else 1
            field = PointField(name=name, offset=offset, count=count)
            field.datatype = POINT_TYPES[kind.base.str[1:]]
            self._fields.append(field)
        self._log = Writer(bag)
        self._log.start()
        self._channels = [
            self._log.register_channel(topic, "cdr", 0) for topic in ("/poses", "/contacts")
        ]
        self.late: list[float] = []
        self._period, self.started = 1.0 / rate, time.monotonic()
        self.create_timer(self._period, self._step)

    def _push(self, name: str, message: WrenchStamped) -> None:
        f, t = message.wrench.force, message.wrench.torque
        self.world[name].apply_wrench((f.x, f.y, f.z), (t.x, t.y, t.z), duration=0.1)

    def _step(self) -> None:
        due = self.started + (self.world.step_count + 1) * self._period
        self.late.append(time.monotonic() - due)
        self.world.step()
        now = self.world.time
        stamp = rclpy.time.Time(nanoseconds=round(now * 1e9)).to_msg()
        poses = PoseArray()
        poses.header.frame_id, poses.header.stamp = "world", stamp
        for p, q in zip(self.world.positions, self.world.orientations, strict=True):
            pose = Pose()
            pose.position.x, pose.position.y, pose.position.z = map(float, p)
            o = pose.orientation
            o.x, o.y, o.z, o.w = map(float, q)
            poses.poses.append(pose)
        points = contact_points(self.world.contacts)
        contacts = PointCloud2(fields=self._fields, height=1, width=len(points), is_dense=True)
        contacts.header = poses.header
        contacts.point_step = CONTACT_POINT.itemsize
        contacts.row_step = len(points) * CONTACT_POINT.itemsize
        contacts.data = points.tobytes()
        self._poses.publish(poses)
        self._contacts.publish(contacts)
        for channel, message in zip(self._channels, (poses, contacts), strict=True):
            moment = round(now * 1e9)
            self._log.add_message(channel, moment, serialize_message(message), moment)

    def finish(self) -> None:
        self._log.finish()


def main() -> None:
    """Step for the time asked for."""
    scene, seconds, rate, pushed, bag = sys.argv[1:6]
    rclpy.init()
    with open(bag, "wb") as file:
        node = PlainNode(scene, float(rate), int(pushed), file)
        cpu = time.process_time()
        end = node.started + float(seconds)
        while (now := time.monotonic()) < end:
            rclpy.spin_once(node, timeout_sec=end - now)
        span = time.monotonic() - node.started
        node.finish()
    asked = round(span * float(rate))
    late = np.array(node.late) * 1e6
    print(json.dumps({
        "lost_steps": asked - int(node.world.step_count),
        "steps_asked": asked,
        "real_time_factor": node.world.time / span,
        "lateness_p50_us": float(np.percentile(late, 50)),
        "lateness_p99_us": float(np.percentile(late, 99)),
        "cpu_per_step_us": (time.process_time() - cpu) / node.world.step_count * 1e6,
        "cpu_share": (time.process_time() - cpu) / span,
    }))  # fmt: skip
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
