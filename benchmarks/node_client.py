"""The other process of the node's benchmark: pushes bodies and watches the poses.

    python -m benchmarks.node_client NODE SECONDS RATE batched|single PUSHED

Sends wrenches to PUSHED bodies RATE times a second, in one message or on a topic each. The force on
the body `probe` changes its sign every few messages; the first pose whose second difference shows
it ends the measurement of a latency. Prints one line of JSON.
"""

from __future__ import annotations

import json
import struct
import sys
import time
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseArray, Wrench, WrenchStamped
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import MultiDOFJointState, PointCloud2

from benchmarks.node_scenes import pushed_bodies

FORCE = 0.01  # N on the bodies of the columns: friction holds them
PROBE_FORCE = 10.0  # N
EVERY = 4  # messages between changes of the probe's force


class Reader:
    """Raw messages of some topics, without an executor."""

    def __init__(self, node: Any, topics: dict[str, Any]) -> None:
        self._context = node.context.handle
        self._subscriptions = {
            name: node.create_subscription(
                kind, name, lambda data: None, QoSProfile(depth=50), raw=True
            )
            for name, kind in topics.items()
        }

    def read(self, seconds: float) -> list[tuple[str, bytes]]:
        """What arrives within `seconds`, or at once what is there already."""
        wait_set = _rclpy.WaitSet(len(self._subscriptions), 0, 0, 0, 0, 0, self._context)
        wait_set.clear_entities()
        for subscription in self._subscriptions.values():
            wait_set.add_subscription(subscription.handle)
        wait_set.wait(int(max(seconds, 0.0) * 1e9))
        messages = []
        for name, subscription in self._subscriptions.items():
            handle, kind = subscription.handle, subscription.msg_type
            while (taken := handle.take_message(kind, True)) is not None:
                messages.append((name, taken[0]))
        return messages


class Pusher:
    """The wrenches, serialised beforehand for both signs of the probe's force."""

    def __init__(self, node: Any, simulator: str, bodies: list[str], batched: bool) -> None:
        self._send = []
        topics = [f"{simulator}/wrenches"] if batched else [
            f"{simulator}/bodies/{body}/wrench" for body in bodies
        ]  # fmt: skip
        kind = MultiDOFJointState if batched else WrenchStamped
        self._publishers = [node.create_publisher(kind, topic, 10) for topic in topics]
        for sign in (1.0, -1.0):
            wrenches = [Wrench() for _ in bodies]
            for body, wrench in zip(bodies, wrenches, strict=True):
                wrench.force.x = sign * PROBE_FORCE if body == "probe" else FORCE
            if batched:
                message = MultiDOFJointState(joint_names=bodies, wrench=wrenches)
                message.header.frame_id = "world"
                self._send.append([serialize_message(message)])
            else:
                stamped = [WrenchStamped(wrench=wrench) for wrench in wrenches]
                for one in stamped:
                    one.header.frame_id = "world"
                self._send.append([serialize_message(one) for one in stamped])

    @property
    def connected(self) -> bool:
        return all(publisher.get_subscription_count() for publisher in self._publishers)

    def push(self, positive: bool) -> None:
        for publisher, data in zip(self._publishers, self._send[not positive], strict=True):
            publisher.publish(data)


def main() -> None:
    """Push and watch for the time asked for."""
    simulator, seconds, rate, how, pushed = sys.argv[1:6]
    rclpy.init()
    node = rclpy.create_node("bench_client")
    bodies = pushed_bodies(int(pushed))
    pusher = Pusher(node, simulator, bodies, how == "batched")
    poses, contacts = f"{simulator}/poses", f"{simulator}/contacts"
    reader = Reader(node, {poses: PoseArray, contacts: PointCloud2})
    while not pusher.connected:
        time.sleep(0.01)
    end = time.monotonic() + float(seconds)
    due, sent, positive, changed_at = time.monotonic(), 0, True, None
    latencies, counts = [], {poses: 0, contacts: 0}
    track: list[float] = []  # x of the probe, the last three
    last_stamp = -1
    while time.monotonic() < end:
        now = time.monotonic()
        if now >= due:
            if sent % EVERY == 0:
                positive = not positive
                changed_at = time.monotonic()
            pusher.push(positive)
            sent += 1
            due += 1.0 / float(rate)
        for name, data in reader.read(due - time.monotonic()):
            counts[name] += 1
            if name != poses:
                continue
            sec, nanosec = struct.unpack_from("<iI", data, 4)
            stamp = sec * 10**9 + nanosec
            x = struct.unpack_from("<d", data, len(data) - 56)[0]
            consecutive = len(track) < 2 or stamp - last_stamp < 1.5 * step_of(
                track, stamp, last_stamp
            )
            track = [*track[-2:], x] if consecutive else [x]
            step = 1e-9 * (stamp - last_stamp)
            last_stamp = stamp
            if len(track) == 3 and changed_at is not None:
                # a dt², half of it from the interval before: the first pose after a change of sign
                # shows none where the old force would go on bending.
                bend = (track[0] - 2 * track[1] + track[2]) * (1.0 if positive else -1.0)
                if bend > -0.5 * PROBE_FORCE * step**2:  # its mass is 1 kg
                    latencies.append(time.monotonic() - changed_at)
                    changed_at = None
    figures = np.array(latencies[5:] or [np.nan]) * 1e3
    print(json.dumps({
        "latency_p50_ms": float(np.percentile(figures, 50)),
        "latency_p99_ms": float(np.percentile(figures, 99)),
        "latencies": len(figures),
        "poses": counts[poses],
        "contacts": counts[contacts],
        "messages_sent": sent * (1 if how == "batched" else len(bodies)),
    }))  # fmt: skip
    rclpy.try_shutdown()


_STEP: list[int] = []


def step_of(track: list[float], stamp: int, last: int) -> int:
    """ns between two poses, the least seen so far."""
    if last >= 0 and stamp > last and (not _STEP or stamp - last < _STEP[0]):
        _STEP[:] = [stamp - last]
    return _STEP[0] if _STEP else stamp - last


if __name__ == "__main__":
    main()
