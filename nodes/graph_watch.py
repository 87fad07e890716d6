"""Warnings about what others do on the graph: publishers and subscribers that can't be heard, a
second publisher, a node of the same name.

rclpy would report incompatible QoS by events; those of a subscription wake the executor with every
message, which costs more than all the rest. So the graph is looked at once a second instead.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterable
from typing import Any

from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

INTERVAL = 1.0  # s of wall time between looks
PATIENCE = 3  # looks after which ends that don't match are told without a reason
NAMED = 20  # bodies in a line
RARELY = 3  # every so many looks at all topics there are


class GraphWatch:
    """Looks at the graph about once a second and says each thing once.

    Parameters
    ----------
    endpoints: the subscriptions and publishers to look at, as they are now, each with what its
    topic carries (`Topic.content`). bodies: the names of those there are.
    """

    def __init__(
        self,
        node: Node,
        endpoints: Callable[[], Iterable[tuple[Subscription | Publisher, str]]],
        bodies: Callable[[], Collection[str]],
    ) -> None:
        self._node = node
        self._endpoints = endpoints
        self._bodies = bodies
        self._next = time.monotonic() + INTERVAL
        self._looks = 0
        self._crowded: set[str] = set()
        self._told: set[str] = set()
        self._unmatched: dict[str, int] = {}  # topic -> looks at which an end was not matched

    def look(self) -> None:
        """Look if it is time to."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + INTERVAL
        for endpoint, content in self._endpoints():
            try:
                if isinstance(endpoint, Subscription):
                    self._look_at_publishers(endpoint, content)
                else:
                    self._look_at_subscribers(endpoint, content)
            except InvalidHandle:  # its body was removed meanwhile
                continue
        self._look_for_a_twin()
        self._looks += 1
        if self._looks % RARELY == 0:
            self._look_for_strangers()

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._node.get_logger().warning(text)

    def _look_at_publishers(self, subscription: Subscription, content: str) -> None:
        topic, count = subscription.topic_name, subscription.get_publisher_count()
        if count < 2:
            self._crowded.discard(topic)
        elif topic not in self._crowded and not topic.startswith("/tf"):  # many feed one tree
            self._crowded.add(topic)
            self._warn_of_several(topic, content, count)
        others = self._node.count_publishers(topic)
        if others <= count:
            self._unmatched.pop(topic, None)
            return
        known = False
        for other in self._node.get_publishers_info_by_topic(topic):
            reason = _mismatch(subscription, other, other.qos_profile, subscription.qos_profile)
            if reason is not None:
                known = True
                self._tell(f"publisher {_name(other)} on {topic} is not heard: {reason}")
        if not known and self._stays(topic):
            self._tell(
                f"{others - count} of {others} publishers on {topic} not heard: something else than the "
                "usual policies does not match, such as the representation of the data (XCDR1 here)"
            )

    def _warn_of_several(self, topic: str, content: str, count: int) -> None:
        if content in ("spawn", "remove", "change"):  # each order is carried out
            return
        text = f"{count} publishers on {topic}: each message replaces the last one, whoever sent it"
        if content in ("wrench", "wrenches"):
            text += (
                "; give every publisher a source of its own (.../wrench/SOURCE in topics.yaml) to have "
                "wrenches add up"
            )
        self._node.get_logger().warning(text)

    def _look_at_subscribers(self, publisher: Publisher, content: str) -> None:
        topic = publisher.topic_name
        if content == "clock" and self._node.count_publishers(topic) > 1:
            self._tell(
                f"another publisher on {topic}: time will jump between the two; end the other simulator "
                "or player, or remap one of the two clocks with --ros-args -r /clock:=/other_clock"
            )
        count, others = publisher.get_subscription_count(), self._node.count_subscribers(topic)
        if others <= count:
            self._unmatched.pop(topic, None)
            return
        known = False
        for other in self._node.get_subscriptions_info_by_topic(topic):
            reason = _mismatch(publisher, other, publisher.qos_profile, other.qos_profile)
            if reason is not None:
                known = True
                self._tell(f"subscriber {_name(other)} on {topic} gets no messages: {reason}")
        if not known and self._stays(topic):
            self._tell(
                f"{others - count} of {others} subscribers on {topic} get no messages: something else "
                "than the usual policies does not match, such as the order of the data's time stamps"
            )

    def _stays(self, topic: str) -> bool:
        """Not matched for several looks: longer than it takes two ends to find each other."""
        self._unmatched[topic] = self._unmatched.get(topic, 0) + 1
        return self._unmatched[topic] > PATIENCE

    def _look_for_strangers(self) -> None:
        """Publishers for a body that there isn't."""
        prefix, bodies = f"{self._node.get_fully_qualified_name()}/bodies/", self._bodies()
        for name, _ in self._node.get_topic_names_and_types():
            body = name.removeprefix(prefix).split("/")[0]
            if name.startswith(prefix) and body not in bodies and self._node.count_publishers(name):
                known = list(bodies)
                more = f" and {len(known) - NAMED} more" if len(known) > NAMED else ""
                self._tell(
                    f"publisher on {name} is not heard: there is no body '{body}'; there are "
                    f"{', '.join(known[:NAMED])}{more}"
                )

    def _look_for_a_twin(self) -> None:
        own = (self._node.get_name(), self._node.get_namespace())
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            self._tell(
                f"another node is called {self._node.get_fully_qualified_name()}: their topics and "
                "services mix; start one with --ros-args -r __node:=NAME or -r __ns:=/NAMESPACE"
            )


def _name(other: Any) -> str:
    return f"{other.node_namespace.rstrip('/')}/{other.node_name}"


def _length(duration: Duration) -> float:
    """ns; where nothing is said it is for ever, which ROS writes as 0 and as its longest duration."""
    length = float(duration.nanoseconds)
    return length if 0.0 < length < 9e18 else math.inf


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
    if _length(asked.deadline) < _length(offered.deadline):
        return "incompatible policy: DEADLINE (asked for is a shorter one than offered)"
    manual = LivelinessPolicy.MANUAL_BY_TOPIC
    if asked.liveliness == manual and offered.liveliness != manual:
        return "incompatible policy: LIVELINESS (asked for is manual_by_topic, offered automatic)"
    if _length(asked.liveliness_lease_duration) < _length(offered.liveliness_lease_duration):
        return "incompatible policy: LIVELINESS (asked for is a shorter lease than offered)"
    if (
        asked.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and offered.durability == DurabilityPolicy.VOLATILE
    ):
        return "incompatible policy: DURABILITY (asked for is transient_local, offered volatile)"
    return None
