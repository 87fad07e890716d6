"""Publishers for every output topic, and the bytes the recorder hands out."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from rb_physics.recording import Recorder
from rb_physics.recording.encoders import encode_string
from rb_physics.recording.outputs import Message
from rb_physics.recording.topics import Topic

from .conversions import message_class, qos_profile

REPEAT = 1.0  # s of wall time between /clock and diagnostics while time stands still
STANDSTILL = 0.5  # s of wall time after which it is more than a moment between two calls of ~/step
LOOK, LOOK_AGAIN = 0.1, 1.0  # s between looks for subscribers: while there are none, and some
AT_ONCE = 12  # messages after one step that may be sent before the next one
FAREWELL = 0.5  # s of wall time at most to wait for readers at the end
OPERATIONS_DEPTH = 1000  # messages of ~/operations a slow reader may lag behind


class _Output:
    """A publisher; one for a single body, of which there may be many, is quiet while nobody listens."""

    def __init__(self, publisher: Publisher, topic: Topic) -> None:
        self.publisher = publisher
        self.content = topic.content
        self.per_body = topic.body is not None
        self.last: bytes | None = None
        self._always = not self.per_body or topic.qos.durability == "transient_local"
        self._listeners = 0
        self._next_look = 0.0

    def is_quiet(self, now: float) -> bool:
        """Nobody listens, and it is not yet time to look again."""
        return self._listeners == 0 and not self._always and now < self._next_look

    def send(self, data: bytes, now: float) -> None:
        """Publish, unless it is known that nobody listens."""
        self.last = data
        if not self._always and now >= self._next_look:
            self._listeners = self.publisher.get_subscription_count()
            self._next_look = now + (LOOK if self._listeners == 0 else LOOK_AGAIN)
        if self._always or self._listeners > 0:
            self.publisher.publish(data)

    def greet(self) -> bool:
        """Send the last message again if there are new subscribers; whether there were."""
        before, self._listeners = self._listeners, self.publisher.get_subscription_count()
        if self._listeners <= before or self.last is None:
            return False
        self.publisher.publish(self.last)
        return True


class Publishing:
    """Publishes what is due as the very bytes that are logged (the Sender of PhysicsLoop).

    Topics of single bodies wait in a queue for the time that is left until the next step: a hundred
    of them at once would make it late.
    """

    def __init__(self, node: Node, world: Any, recorder: Recorder) -> None:
        self._node = node
        self._world = world
        self.stands_still: Callable[[], bool] = lambda: False  # nothing moves before it is told to
        self._started = False
        self._repeat = 0.0
        self._still_since: float | None = None
        self._shown = False  # the state in which everything stands still
        self._clocks = [t.name for t in recorder.outputs.topics if t.content == "clock"]
        self._recorder = recorder
        self._outputs: dict[str, _Output] = {}
        self._waiting: deque[tuple[_Output, bytes]] = deque()
        self._missing: set[str] = set()
        self.fit()
        self._operations = node.create_publisher(
            String, "~/operations", QoSProfile(depth=OPERATIONS_DEPTH)
        )

    def fit(self) -> None:
        """A publisher for each output topic; called again when bodies were added or removed."""
        self.flush()
        wanted = {t.name: t for t in self._recorder.outputs.topics if t.direction == "out"}
        for name in [name for name in self._outputs if name not in wanted]:
            self._node.destroy_publisher(self._outputs.pop(name).publisher)
        for name, topic in wanted.items():
            if name not in self._outputs and name not in self._missing:
                self._create(topic)

    def _create(self, topic: Topic) -> None:
        try:
            kind = message_class(topic.type)
        except ImportError as error:
            self._missing.add(topic.name)
            self._node.get_logger().info(f"{topic.name} is logged but not published: {error}")
            return
        publisher = self._node.create_publisher(
            kind,
            topic.name,
            qos_profile(topic.qos),
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        )
        self._outputs[topic.name] = _Output(publisher, topic)

    @property
    def publishers(self) -> list[tuple[Publisher, str]]:
        """Those of all output topics, each with what it carries."""
        return [(output.publisher, output.content) for output in list(self._outputs.values())]

    def start(self, world: Any) -> None:
        """Send the whole state: at the start of a run, after a reset and when bodies come or go."""
        self._publish(self._recorder.latched())
        self._still_since, self._shown = None, False
        messages = self._recorder.outputs.collect(everything=True)
        if self._started:
            self._show(messages)
        else:  # the recorder itself logs the first ones
            self._publish(messages)
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
        """Send what is due after steps; `flush` or `send_until` send the rest."""
        self._still_since, self._shown = None, False
        self._recorder.after_step(self._publish)

    def send_until(self, deadline: float) -> None:
        """Send what still waits, as long as time.monotonic() is before `deadline`."""
        waiting = self._waiting
        while waiting and (now := time.monotonic()) < deadline:
            output, data = waiting.popleft()
            output.send(data, now)

    def flush(self) -> None:
        """Send all that still waits."""
        self.send_until(math.inf)

    def idle(self, world: Any) -> None:
        """While nothing moves: show newcomers the last messages, and repeat /clock every second.

        Where everything stands still for more than a moment the present state is sent, whatever
        is due, and then the diagnostics every second.
        """
        self.flush()
        now = time.monotonic()
        if not self._shown and self.stands_still():
            self._still_since = now if self._still_since is None else self._still_since
            if now >= self._still_since + STANDSTILL:
                self._shown = True
                self._show(self._recorder.outputs.present())
        for output in self._outputs.values():
            output.greet()
        if now >= self._repeat:
            self._repeat = now + REPEAT
            for name in self._clocks:
                data = self._outputs[name].last
                if data is not None:
                    self._outputs[name].send(data, now)
            if self._shown:
                self._publish(self._recorder.outputs.diagnostics())

    def _show(self, messages: list[Message]) -> None:
        """Send and log what no step made due."""
        self._publish(messages)
        for name, data in messages:
            self._recorder.write_input(name, data)

    def finish(self) -> None:
        """Let readers get the last messages before the node goes."""
        self.flush()
        end = time.monotonic() + FAREWELL
        for output in self._outputs.values():
            left = max(0.0, end - time.monotonic())
            output.publisher.wait_for_all_acked(Duration(seconds=left))

    def destroy(self, node: Node) -> None:
        """Take the publishers away."""
        for output in self._outputs.values():
            node.destroy_publisher(output.publisher)
        node.destroy_publisher(self._operations)

    def _publish(self, messages: list[tuple[str, bytes]]) -> None:
        if not messages:
            return
        now = time.monotonic()
        several = len(messages) > AT_ONCE
        if several and self._waiting:
            self.flush()  # the last ones of each topic come first
        for name, data in messages:
            output = self._outputs.get(name)
            if output is None:
                continue
            if output.is_quiet(now):
                output.last = data
            elif several and output.per_body:
                self._waiting.append((output, data))
            else:
                output.send(data, now)
