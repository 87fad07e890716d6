"""`replay_node`: publishes a recording again, with its timing and its bytes.

Parameters: recording (folder), rate (1 is the original speed, 0 as fast as possible), start (s of the
recording's time at which to begin), loop, and inputs (publish the recorded inputs, too).
"""

from __future__ import annotations

import json
import math
import signal
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any

from .start import StartError, import_rclpy, one_line

NAME = "replay_node"
FAREWELL = 0.5  # s of wall time at most to wait for the readers of each topic at the end


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay until the end, SIGINT or SIGTERM. Returns the exit code."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    try:
        rclpy = import_rclpy()
        from rclpy.signals import SignalHandlerOptions

        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        try:
            Replay(rclpy.create_node(NAME)).run(stop)
        except (ValueError, OSError, ImportError) as error:
            raise StartError(one_line(error)) from None
        finally:
            rclpy.try_shutdown()
    except StartError as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    return 0


class Replay:
    """One recording, its publishers, and the loop that sends what is due."""

    def __init__(self, node: Any) -> None:
        from rb_physics.recording.log_reader import Recording

        declare = node.declare_parameter
        path = declare("recording", "").value
        self._rate = float(declare("rate", 1.0).value)
        self._start = round(float(declare("start", 0.0).value) * 1e9)
        self._loop = bool(declare("loop", False).value)
        with_inputs = bool(declare("inputs", False).value)
        if not path:
            raise ValueError("set the parameter recording to the folder of a recording")
        if not 0.0 <= self._rate < math.inf:
            raise ValueError(f"parameter rate is {self._rate}, but must be a finite number >= 0")
        self._recording = Recording(path)
        self._publishers: dict[str, Any] = {}
        self._latched: set[str] = set()
        topics = self._recording.attachments().get("topics.json")
        if topics is None:
            raise ValueError(f"{path} was not made by rb_physics: replay it with ros2 bag play")
        for topic in json.loads(topics):
            if topic["direction"] == "out" or with_inputs:
                self._create(node, topic)

    def _create(self, node: Any, topic: dict[str, Any]) -> None:
        from rb_physics.recording.topics import Qos

        from .conversions import message_class, qos_profile

        name, qos = topic["name"], Qos(**topic["qos"])
        try:
            kind = message_class(topic["type"])
        except ImportError as error:
            node.get_logger().info(f"{name} is not replayed: {error}")
            return
        self._publishers[name] = node.create_publisher(kind, name, qos_profile(qos))
        if qos.durability == "transient_local":
            self._latched.add(name)

    def run(self, stop: threading.Event) -> None:
        """Send everything; again and again with `loop`."""
        while self._play(stop) and self._loop:
            pass
        from rclpy.duration import Duration

        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=FAREWELL))

    def _play(self, stop: threading.Event) -> bool:
        """Once from the start; False when it was stopped."""
        begin: float | None = None
        for message in self._recording.messages(set(self._publishers)):
            if message.log_time < self._start:
                if message.topic in self._latched:
                    self._publishers[message.topic].publish(bytes(message.data))
                continue
            if begin is None:
                begin, first = time.monotonic(), message.log_time
            if self._rate > 0.0:
                due = begin + (message.log_time - first) * 1e-9 / self._rate
                _sleep_until(due, stop)
            if stop.is_set():
                return False
            self._publishers[message.topic].publish(bytes(message.data))
        return begin is not None


def _sleep_until(due: float, stop: threading.Event) -> None:
    """Not `stop.wait`: its lock could be held when the signal handler sets the event."""
    while not stop.is_set() and (left := due - time.monotonic()) > 0.0:
        time.sleep(min(left, 0.1))


if __name__ == "__main__":
    sys.exit(main())
