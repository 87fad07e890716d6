"""Publishers for every output topic, and the bytes the recorder hands out."""

from __future__ import annotations

import time
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from rb_physics.recording import Recorder
from rb_physics.recording.encoders import encode_string
from rb_physics.recording.topics import Topic

from .conversions import message_class, qos_profile

CLOCK_REPEAT = 1.0  # s of wall time between repetitions of /clock while time stands still
FAREWELL = 0.5  # s of wall time at most to wait for readers at the end
OPERATIONS_DEPTH = 1000  # messages of ~/operations a slow reader may lag behind


class Publishing:
    """Publishes what is due as the very bytes that are logged (the Sender of PhysicsLoop)."""

    def __init__(self, node: Node, world: Any, recorder: Recorder) -> None:
        self._node = node
        self._world = world
        self._started = False
        self._repeat_clock = 0.0
        self._clocks = {t.name for t in recorder.outputs.topics if t.content == "clock"}
        self._recorder = recorder
        self._publishers: dict[str, Any] = {}
        self._last: dict[str, bytes] = {}
        self._subscribers: dict[str, int] = {}
        self._missing: set[str] = set()
        self.fit()
        self._operations = node.create_publisher(
            String, "~/operations", QoSProfile(depth=OPERATIONS_DEPTH)
        )

    def fit(self) -> None:
        """A publisher for each output topic; called again when bodies were added or removed."""
        wanted = {t.name: t for t in self._recorder.outputs.topics if t.direction == "out"}
        for name in [name for name in self._publishers if name not in wanted]:
            self._node.destroy_publisher(self._publishers.pop(name))
            self._last.pop(name, None)
            self._subscribers.pop(name, None)
        for name, topic in wanted.items():
            if name not in self._publishers and name not in self._missing:
                self._create(topic)

    def _create(self, topic: Topic) -> None:
        try:
            kind = message_class(topic.type)
        except ImportError as error:
            self._missing.add(topic.name)
            self._node.get_logger().info(f"{topic.name} is logged but not published: {error}")
            return
        self._publishers[topic.name] = self._node.create_publisher(
            kind, topic.name, qos_profile(topic.qos)
        )

    def start(self, world: Any) -> None:
        """Send the whole state: at the start of a run, after a reset and when bodies come or go."""
        self._publish(self._recorder.latched())
        messages = self._recorder.outputs.collect(everything=True)
        self._publish(messages)
        if self._started:  # the recorder itself logs the first ones
            for name, data in messages:
                self._recorder.write_input(name, data)
        self._started = True

    def perform(self, name: str, **arguments: Any) -> None:
        """Change the world through the recorder, and say so with the step it takes effect in."""
        text = self._recorder.perform(name, **arguments)
        if self._operations.get_subscription_count() > 0:
            self._operations.publish(encode_string(text))

    def steps_until_due(self, world: Any) -> int:
        """How many steps may be made before something must be sent."""
        return self._recorder.steps_until_due()

    def accepted(self, world: Any, messages: list[tuple[Topic, bytes]]) -> None:
        """Log messages that act from the next step on."""
        for topic, data in messages:
            self._recorder.write_input(topic.name, data)

    def stepped(self, world: Any) -> None:
        """Send what is due after steps."""
        self._publish(self._recorder.after_step())

    def idle(self, world: Any) -> None:
        """While nothing moves: show newcomers the last messages, and repeat /clock every second."""
        now = time.monotonic()
        repeat = now >= self._repeat_clock
        if repeat:
            self._repeat_clock = now + CLOCK_REPEAT
        for name, data in self._last.items():
            count = self._publishers[name].get_subscription_count()
            if count > self._subscribers.get(name, 0) or (repeat and name in self._clocks):
                self._publishers[name].publish(data)
            self._subscribers[name] = count

    def finish(self) -> None:
        """Let readers get the last messages before the node goes."""
        end = time.monotonic() + FAREWELL
        for name in self._last:
            left = max(0.0, end - time.monotonic())
            self._publishers[name].wait_for_all_acked(Duration(seconds=left))

    def destroy(self, node: Node) -> None:
        """Take the publishers away."""
        for publisher in (*self._publishers.values(), self._operations):
            node.destroy_publisher(publisher)

    def _publish(self, messages: list[tuple[str, bytes]]) -> None:
        for name, data in messages:
            publisher = self._publishers.get(name)
            if publisher is not None:
                publisher.publish(data)
                self._last[name] = data
