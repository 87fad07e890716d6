"""What other nodes send, from raw bytes to what acts on the bodies."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from typing import Any

from rb_physics.recording import decoders
from rb_physics.recording.topics import Topic

from . import body_inputs
from .inbox import Inbox
from .kinematic_inputs import KinematicInputs
from .lockstep import Lockstep
from .refused import MalformedMessageError, RefusedInputError, RefusedValueError
from .transform_tree import TransformTree
from .wrench_frames import WrenchFrames
from .wrench_inputs import HeldWrenches, Perform, WrenchInputs, WrenchSource

Complain = Callable[[str, str], None]  # key for throttling, text


def _decode_text(data: bytes) -> str:
    try:
        return decoders.decode_string(data)
    except ValueError as error:
        raise ValueError(f"malformed std_msgs/msg/String: {error}") from None


NAMED = 5  # topics in a line
IGNORED = object()  # what a handler returns for a message that is no input of this world


class Inputs:
    """All input topics of a world. Only the physics thread uses it, but for `inbox.put`.

    Parameters
    ----------
    world: the simulated World.
    topics: the input topics, in the order that settles who comes first.
    complain: called with (topic, sentence) for every refused message.
    """

    def __init__(
        self,
        world: Any,
        topics: Sequence[Topic],
        wrench_timeout: float,
        cmd_vel_timeout: float,
        lockstep: bool,
        complain: Complain,
    ) -> None:
        self.inbox = Inbox()
        self.counters: Counter[str] = Counter()
        self._complain = complain
        self.wrenches = WrenchInputs(world.settings.dt, wrench_timeout)
        self.motions = KinematicInputs(world.settings.dt, cmd_vel_timeout)
        self.transforms = TransformTree()
        self.lockstep = Lockstep() if lockstep else None
        self._batches: defaultdict[str, Any] = defaultdict(decoders.MultiDofJointsDecoder)
        self.fit(world, topics)

    def fit(self, world: Any, topics: Sequence[Topic]) -> None:
        """The bodies of the world and so the topics are these now."""
        self.topics = tuple(topics)
        self.bodies = [body.name for body in world.bodies]
        self._by_name = {topic.name: topic for topic in self.topics}
        self._rank = {topic.name: rank for rank, topic in enumerate(self.topics)}
        moving = [body for body in world.bodies if body.type != "static"]
        dynamic = {
            b.name: WrenchFrames(b.name, b.center_of_mass, b.frames)
            for b in moving
            if b.type == "dynamic"
        }
        wrenches = [t for t in self.topics if t.content in ("wrench", "wrenches")]
        self.wrenches.fit([WrenchSource(t.name, t.body) for t in wrenches], dynamic)
        self.motions.fit({b.name: b.center_of_mass for b in moving if b.type == "kinematic"})
        self._driven = {  # body -> its frame on /tf
            body: topic.frame.replace("NAME", body).strip("/")
            for topic in self.topics
            for body in topic.bodies
        }
        free = [body for body in world.bodies if body.name not in self._driven]
        self._own_frames = {body.name for body in free}  # on /tf: published by this node
        self._own_frames |= {
            f"{body.name}/{frame}" for body in world.bodies for frame in ("com", *body.frames)
        }
        if self.lockstep is not None:
            single = [t.name for t in wrenches if t.content == "wrench"]
            self.lockstep.wait_for(single or [t.name for t in wrenches])
        self._first_source: dict[str, str] = {}  # body -> its first wrench topic
        for topic in wrenches:
            if topic.body is not None:
                self._first_source.setdefault(topic.body, topic.name)

    def receive(self, world: Any, step: int, perform: Perform) -> list[tuple[Topic, bytes]]:
        """Take in what has arrived, for step `step`. Returns the messages that were accepted."""
        accepted = []
        for name, data in self.inbox.take(lambda topic: self._rank.get(topic, -1)):
            topic = self._by_name.get(name)
            if topic is None:  # of a body that was removed meanwhile
                self.counters["discarded_by_removal"] += 1
                continue
            try:
                handle = getattr(self, f"_receive_{topic.content}")
                if handle(world, topic, data, step, perform) is IGNORED:
                    self.counters["ignored"] += 1
                    continue
            except RefusedInputError as error:
                self.counters["refused"] += 1
                self.counters[error.counter] += 1
                self._complain(topic.name, str(error))
            else:
                self.counters["accepted"] += 1
                accepted.append((topic, data))
        return accepted

    def wait(self, world: Any) -> None:
        """A step in lockstep waits for messages: say for which if it takes long."""
        assert self.lockstep is not None
        missing = self.lockstep.overdue()
        if missing:
            more = f" and {len(missing) - NAMED} more" if len(missing) > NAMED else ""
            self._complain(
                "lockstep",
                f"the step that starts at {round(world.time * 1e9)} ns waits in lockstep for the message on "
                f"{', '.join(missing[:NAMED])}{more}; a body without a controller is left out of the "
                "wrench entries of topics.yaml, one that is spawned joins those of its kind",
            )

    @staticmethod
    def _decoded(topic: Topic, data: bytes, decode: Callable[[bytes], Any]) -> Any:
        try:
            return decode(data)
        except ValueError as error:
            raise MalformedMessageError(f"message on {topic.name} refused: {error}") from None

    def _receive_wrench(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        message = self._decoded(topic, data, decoders.decode_wrench_stamped)
        values, body = message.values, str(topic.body)
        wrench = self.wrenches.resolve(body, message.frame_id, values[:3], values[3:])
        if self.lockstep is not None:
            self.lockstep.admit((), topic.name, message.time_ns, round(world.time * 1e9))
        self.wrenches.hold(topic.name, HeldWrenches.of(body, wrench))

    def _receive_wrenches(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        message = self._decoded(topic, data, self._batches[topic.name].decode)
        for field, rows in (("transforms", message.transforms), ("twist", message.twists)):
            if len(rows):
                raise RefusedValueError(
                    f"message on {topic.name} refused: {field} has {len(rows)} entries, but must stay "
                    "empty: only wrenches are taken here"
                )
        wrenches = self.wrenches.resolve_batch(
            topic.name, message.frame_id, message.names, message.wrenches
        )
        if self.lockstep is not None:
            instead_of = [self._first_source[b] for b in wrenches.bodies if b in self._first_source]
            self.lockstep.admit(instead_of, topic.name, message.time_ns, round(world.time * 1e9))
        self.wrenches.hold(topic.name, wrenches)

    def _receive_cmd_pose(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        message = self._decoded(topic, data, decoders.decode_pose_stamped)
        self.motions.receive_pose(
            world, str(topic.body), message.frame_id, message.values, message.time_ns, step
        )

    def _receive_cmd_vel(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        message = self._decoded(topic, data, decoders.decode_twist_stamped)
        self.motions.receive_twist(str(topic.body), message.frame_id, message.values, step)

    def _receive_cmd_tf(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> object:
        transforms = self._decoded(topic, data, decoders.decode_transforms)
        static = topic.qos.durability == "transient_local"
        self.transforms.update(transforms, topic.name, static)
        if all(child in self._own_frames for _, _, child, _ in transforms):
            return IGNORED
        if static:
            return None
        for body, frame in self._driven.items():
            try:
                position, orientation, stamp = self.transforms.pose(frame)
            except RefusedInputError as error:
                self._complain(f"{topic.name} {body}", f"body '{body}' stays where it is: {error}")
                continue
            self.motions.follow(world, body, position, orientation, stamp, step, perform)
        return None

    def _receive_spawn(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        text = self._decoded(topic, data, _decode_text)
        body_inputs.spawn(world, topic.name, text, perform)

    def _receive_remove(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        text = self._decoded(topic, data, _decode_text)
        body_inputs.remove(world, topic.name, text, perform)

    def _receive_change(
        self, world: Any, topic: Topic, data: bytes, step: int, perform: Perform
    ) -> None:
        text = self._decoded(topic, data, _decode_text)
        body_inputs.change(world, topic.name, text, perform)

    def apply(self, world: Any, step: int, perform: Perform) -> None:
        """Let everything received act from step `step` on."""
        self.wrenches.apply(step, perform)
        self.motions.apply(world, step, perform)

    def clear(self, step: int, perform: Perform) -> None:
        """Forget everything commanded so far, messages that still wait included."""
        self.counters["discarded_by_reset"] += len(self.inbox.take(lambda topic: 0))
        self.wrenches.clear(step, perform)
        self.motions.clear(perform)
        self.transforms.clear()
        if self.lockstep is not None:
            self.lockstep.next_step()
