"""Warnings about what others do on the graph: publishers and subscribers that can't be heard, a
second publisher, a node of the same name.

rclpy would report incompatible QoS by events; those of a subscription wake the executor with every
message, which costs more than all the rest. So the graph is looked at once a second instead.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

INTERVAL = 1.0  # s of wall time between looks


class GraphWatch:
    """Looks at the graph about once a second and says each thing once.

    Parameters
    ----------
    endpoints: the subscriptions and publishers to look at, as they are now.
    """

    def __init__(
        self, node: Node, endpoints: Callable[[], Iterable[Subscription | Publisher]]
    ) -> None:
        self._node = node
        self._endpoints = endpoints
        self._next = time.monotonic() + INTERVAL
        self._crowded: set[str] = set()
        self._told: set[str] = set()

    def look(self) -> None:
        """Look if it is time to."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + INTERVAL
        for endpoint in self._endpoints():
            try:
                if isinstance(endpoint, Subscription):
                    self._look_at_publishers(endpoint)
                else:
                    self._look_at_subscribers(endpoint)
            except InvalidHandle:  # its body was removed meanwhile
                continue
        self._look_for_a_twin()

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._node.get_logger().warning(text)

    def _look_at_publishers(self, subscription: Subscription) -> None:
        topic, count = subscription.topic_name, subscription.get_publisher_count()
        if count < 2:
            self._crowded.discard(topic)
        elif topic not in self._crowded and not topic.startswith("/tf"):  # many feed one tree
            self._crowded.add(topic)
            self._node.get_logger().warning(
                f"{count} publishers on {topic}: each message replaces the last one, whoever "
                "sent it; give every publisher a source of its own (.../wrench/SOURCE in "
                "topics.yaml) to have wrenches add up"
            )
        if self._node.count_publishers(topic) <= count:
            return
        for other in self._node.get_publishers_info_by_topic(topic):
            reason = _mismatch(subscription, other, other.qos_profile, subscription.qos_profile)
            if reason is not None:
                self._tell(f"publisher {_name(other)} on {topic} is not heard: {reason}")

    def _look_at_subscribers(self, publisher: Publisher) -> None:
        topic = publisher.topic_name
        if self._node.count_subscribers(topic) <= publisher.get_subscription_count():
            return
        for other in self._node.get_subscriptions_info_by_topic(topic):
            reason = _mismatch(publisher, other, publisher.qos_profile, other.qos_profile)
            if reason is not None:
                self._tell(f"subscriber {_name(other)} on {topic} gets no messages: {reason}")

    def _look_for_a_twin(self) -> None:
        own = (self._node.get_name(), self._node.get_namespace())
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            self._tell(
                f"another node is called {self._node.get_fully_qualified_name()}: their topics and "
                "services mix; start one with --ros-args -r __node:=NAME or -r __ns:=/NAMESPACE"
            )


def _name(other: Any) -> str:
    return f"{other.node_namespace.rstrip('/')}/{other.node_name}"


def _mismatch(
    own: Subscription | Publisher, other: Any, offered: QoSProfile, asked: QoSProfile
) -> str | None:
    """Why the two ends don't match, or None."""
    module = own.msg_type.__module__.split(".")[0]
    kind = f"{module}/msg/{own.msg_type.__name__}"
    if other.topic_type != kind:
        return f"its type is {other.topic_type}, the topic's is {kind}"
    if (
        asked.reliability == ReliabilityPolicy.RELIABLE
        and offered.reliability == ReliabilityPolicy.BEST_EFFORT
    ):
        return "incompatible policy: RELIABILITY (asked for is reliable, offered best_effort)"
    if (
        asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and offered.durability == DurabilityPolicy.VOLATILE
    ):
        return "incompatible policy: DURABILITY (asked for is transient_local, offered volatile)"
    return None
