"""Subscriptions to every input topic, waited for in a thread of their own.

rclpy's executor builds a wait set of all entities of a node for every message, which takes most of
a core at a few thousand messages a second on a hundred topics. Here one wait set holds the input
subscriptions only, and every wake-up takes all that has arrived, as raw bytes.
"""

from __future__ import annotations

import threading
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.subscription import Subscription

from .commands import CommandQueue
from .conversions import message_class, qos_profile
from .graph_watch import GraphWatch
from .inputs import Inputs

WAIT = 100_000_000  # ns between looks at the request to stop


class _NotInExecutor(CallbackGroup):
    """Callback group of what the node's executor must leave alone."""

    def can_execute(self, entity: Any) -> bool:
        return False

    def beginning_execution(self, entity: Any) -> bool:
        return False

    def ending_execution(self, entity: Any) -> None:
        pass


class Subscribing:
    """One raw subscription for each input topic, in topic order, and the thread that reads them."""

    def __init__(self, node: Node, inputs: Inputs, commands: CommandQueue) -> None:
        self._inputs = inputs
        self._commands = commands
        self._context = node.context
        self._stopping = threading.Event()
        group = _NotInExecutor()
        self._subscriptions = [
            node.create_subscription(
                message_class(topic.type),
                topic.name,
                self._never_called,
                qos_profile(topic.qos),
                callback_group=group,
                raw=True,
            )
            for topic in inputs.topics
        ]
        for subscription in self._subscriptions:
            self._leave_events_to_executor(node, subscription)
        self._watch = GraphWatch(node, self._subscriptions)
        self._thread = threading.Thread(target=self._run, name="inputs", daemon=True)

    @staticmethod
    def _leave_events_to_executor(node: Node, subscription: Subscription) -> None:
        """So that a publisher with incompatible QoS is still reported by rclpy."""
        for handler in subscription.event_handlers:
            handler.callback_group = node.default_callback_group
            node.default_callback_group.add_entity(handler)

    def start(self) -> None:
        """Begin to take messages."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join()

    def destroy(self, node: Node) -> None:
        """Take the subscriptions away; the thread has ended."""
        for subscription in self._subscriptions:
            node.destroy_subscription(subscription)

    def _never_called(self, data: bytes) -> None:
        raise AssertionError("input subscriptions are read by the input thread")

    def _run(self) -> None:
        handles = [subscription.handle for subscription in self._subscriptions]
        if not handles:
            return
        kinds = [subscription.msg_type for subscription in self._subscriptions]
        index_of = {handle.pointer: index for index, handle in enumerate(handles)}
        put, lockstep = self._inputs.inbox.put, self._inputs.lockstep is not None
        wait_set = _rclpy.WaitSet(len(handles), 0, 0, 0, 0, 0, self._context.handle)
        while not self._stopping.is_set():
            wait_set.clear_entities()
            for handle in handles:
                wait_set.add_subscription(handle)
            wait_set.wait(WAIT)
            for pointer in wait_set.get_ready_entities("subscription"):
                index = index_of[pointer]
                while (taken := handles[index].take_message(kinds[index], True)) is not None:
                    put(index, taken[0])
            if lockstep:
                self._commands.wake()
            self._watch.look()
