"""Warnings about what others do on the graph: a second publisher, a node of the same name."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rclpy.node import Node
from rclpy.subscription import Subscription

INTERVAL = 1.0  # s of wall time between looks


class GraphWatch:
    """Looks at the graph about once a second and says each thing once."""

    def __init__(self, node: Node, subscriptions: Callable[[], Sequence[Subscription]]) -> None:
        self._node = node
        self._subscriptions = subscriptions
        self._next = time.monotonic() + INTERVAL
        self._crowded: set[str] = set()
        self._twin = False

    def look(self) -> None:
        """Look if it is time to."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + INTERVAL
        self._look_at_publishers()
        if not self._twin:
            self._look_for_a_twin()

    def _look_at_publishers(self) -> None:
        for subscription in self._subscriptions():
            topic, count = subscription.topic_name, subscription.get_publisher_count()
            if count < 2:
                self._crowded.discard(topic)
            elif topic not in self._crowded:
                self._crowded.add(topic)
                self._node.get_logger().warning(
                    f"{count} publishers on {topic}: each message replaces the last one, whoever "
                    "sent it; give every publisher a source of its own (.../wrench/SOURCE in "
                    "topics.yaml) to have wrenches add up"
                )

    def _look_for_a_twin(self) -> None:
        own = (self._node.get_name(), self._node.get_namespace())
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            self._twin = True
            self._node.get_logger().warning(
                f"another node is called {self._node.get_fully_qualified_name()}: their topics and "
                "services mix; start one with --ros-args -r __node:=NAME or -r __ns:=/NAMESPACE"
            )
