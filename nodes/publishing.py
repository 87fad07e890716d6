"""Publishers for every output topic, and the bytes the recorder hands out."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from rb_physics.recording import Recorder
from rb_physics.recording.topics import Topic

from .conversions import message_class, qos_profile


class Publishing:
    """Publishes what is due as the very bytes that are logged (the Sender of PhysicsLoop)."""

    def __init__(self, node: Node, recorder: Recorder) -> None:
        self._node = node
        self._recorder = recorder
        self._publishers: dict[str, Any] = {}
        self._last: dict[str, bytes] = {}
        self._subscribers: dict[str, int] = {}
        for topic in recorder.outputs.topics:
            if topic.direction == "out":
                self._create(topic)

    def _create(self, topic: Topic) -> None:
        try:
            kind = message_class(topic.type)
        except ImportError as error:
            self._node.get_logger().info(f"{topic.name} is logged but not published: {error}")
            return
        self._publishers[topic.name] = self._node.create_publisher(
            kind, topic.name, qos_profile(topic.qos)
        )

    def start(self, world: Any) -> None:
        """Send what is sent once, and what is due at the start of a run."""
        self._publish(self._recorder.latched())

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
        """While nothing moves, show newcomers the last message of each topic."""
        for name, data in self._last.items():
            count = self._publishers[name].get_subscription_count()
            if count > self._subscribers.get(name, 0):
                self._publishers[name].publish(data)
            self._subscribers[name] = count

    def _publish(self, messages: list[tuple[str, bytes]]) -> None:
        for name, data in messages:
            publisher = self._publishers.get(name)
            if publisher is not None:
                publisher.publish(data)
                self._last[name] = data
