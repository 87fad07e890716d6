"""Subscriptions to every input topic, waited for in a thread of their own.

rclpy's executor builds a wait set of all entities of a node for every message, which takes most of
a core at a few thousand messages a second on a hundred topics. Here one wait set holds the input
subscriptions only, and every wake-up takes all that has arrived, as raw bytes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from rb_physics.recording.topics import Topic

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
    """One raw subscription for each input topic, in topic order, and the thread that reads them.

    Raises ImportError when a topic's type is not installed.
    """

    def __init__(
        self,
        node: Node,
        inputs: Inputs,
        commands: CommandQueue,
        publishers: Callable[[], list[tuple[Publisher, str]]],
    ) -> None:
        self._node = node
        self._inputs = inputs
        self._commands = commands
        self._stopping = threading.Event()
        self._group = _NotInExecutor()
        self._subscriptions: dict[str, Subscription] = {}
        self._lock = threading.Lock()  # of what follows
        self._changed = False
        self._leaving: list[Subscription] = []  # to be destroyed once no wait set holds them
        # A subscription must not be destroyed while it is waited for: this ends the wait.
        self._guard = node.create_guard_condition(lambda: None, callback_group=self._group)
        self.fit()
        self._watch = GraphWatch(
            node, lambda: [*self._with_contents(), *publishers()], lambda: inputs.bodies
        )
        self._thread = threading.Thread(target=self._run, name="inputs", daemon=True)

    def fit(self) -> None:
        """A subscription for each input topic; called again when bodies were added or removed."""
        wanted = {topic.name: topic for topic in self._inputs.topics}
        kept = {n: s for n, s in self._subscriptions.items() if n in wanted}
        created = {n: self._create(t) for n, t in wanted.items() if n not in kept}
        with self._lock:
            self._leaving += [s for n, s in self._subscriptions.items() if n not in kept]
            self._subscriptions = kept | created
            self._changed = True
        self._guard.trigger()

    def _create(self, topic: Topic) -> Subscription:
        return self._node.create_subscription(
            message_class(topic.type),
            topic.name,
            self._never_called,
            qos_profile(topic.qos),
            callback_group=self._group,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            raw=True,
        )

    def start(self) -> None:
        """Begin to take messages, if that hasn't been done."""
        if self._thread.ident is None:
            self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._stopping.set()
        self._guard.trigger()
        if self._thread.is_alive():
            self._thread.join()

    def destroy(self, node: Node) -> None:
        """Take the subscriptions away; the thread has ended."""
        for subscription in (*self._subscriptions.values(), *self._leaving):
            node.destroy_subscription(subscription)
        node.destroy_guard_condition(self._guard)

    def _with_contents(self) -> list[tuple[Subscription, str]]:
        subscriptions = self._subscriptions
        return [
            (subscriptions[t.name], t.content)
            for t in self._inputs.topics
            if t.name in subscriptions
        ]

    def _never_called(self, data: bytes) -> None:
        raise AssertionError("input subscriptions are read by the input thread")

    def _take_changes(self) -> dict[str, Subscription] | None:
        """The subscriptions, if they are others than before."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            leaving, self._leaving = self._leaving, []
            present = dict(self._subscriptions)
        for subscription in leaving:
            self._node.destroy_subscription(subscription)
        return present

    def _run(self) -> None:
        put, lockstep = self._inputs.inbox.put, self._inputs.lockstep is not None
        context = self._node.context.handle
        handles: list[Any] = []
        topic_of: dict[int, tuple[str, Any, Any]] = {}
        wait_set = _rclpy.WaitSet(0, 1, 0, 0, 0, 0, context)
        while not self._stopping.is_set():
            present = self._take_changes()
            if present is not None:
                handles = [subscription.handle for subscription in present.values()]
                topic_of = {
                    subscription.handle.pointer: (name, subscription.handle, subscription.msg_type)
                    for name, subscription in present.items()
                }
                wait_set = _rclpy.WaitSet(len(handles), 1, 0, 0, 0, 0, context)
            wait_set.clear_entities()
            wait_set.add_guard_condition(self._guard.handle)
            for handle in handles:
                wait_set.add_subscription(handle)
            wait_set.wait(WAIT)
            for pointer in wait_set.get_ready_entities("subscription"):
                name, handle, kind = topic_of[pointer]
                while (taken := handle.take_message(kind, True)) is not None:
                    put(name, taken[0])
            if lockstep:
                self._commands.wake()
            self._watch.look()
