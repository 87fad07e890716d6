"""What other nodes send, from raw bytes to what acts on the bodies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from rb_physics.recording.decoders import (
    decode_pose_stamped,
    decode_twist_stamped,
    decode_wrench_stamped,
)
from rb_physics.recording.topics import Topic

from .inbox import Inbox
from .kinematic_inputs import KinematicInputs
from .lockstep import Lockstep
from .refused import MalformedMessageError, RefusedInputError
from .wrench_frames import WrenchFrames
from .wrench_inputs import Perform, WrenchInputs, WrenchSource

Complain = Callable[[str, str], None]  # key for throttling, text


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
        self.topics = tuple(topics)
        self.inbox = Inbox()
        self.counters: Counter[str] = Counter()
        self._complain = complain
        self._sources: dict[int, int] = {}  # topic index -> wrench source index
        sources = []
        for index, topic in enumerate(self.topics):
            if topic.content == "wrench":
                self._sources[index] = len(sources)
                name = topic.name.rsplit("/wrench", 1)[-1].strip("/")
                sources.append(WrenchSource(str(topic.body), name, topic.name))
        self._check_bodies(world)
        moving = [body for body in world.bodies if body.type != "static"]
        frames = {b.name: WrenchFrames(b.name, b.center_of_mass, b.frames) for b in moving}
        centers = {body.name: body.center_of_mass for body in moving}
        self.wrenches = WrenchInputs(sources, frames, world.settings.dt, wrench_timeout)
        self.motions = KinematicInputs(centers, world.settings.dt, cmd_vel_timeout)
        self.lockstep = Lockstep(len(sources)) if lockstep else None

    def _check_bodies(self, world: Any) -> None:
        for topic in self.topics:
            needed = "dynamic" if topic.content == "wrench" else "kinematic"
            given = world[topic.body].type
            if given != needed:
                raise ValueError(
                    f"topic {topic.name} is for a {needed} body, but '{topic.body}' is {given}: "
                    f"take it out of `bodies` in topics.yaml"
                )

    def receive(self, world: Any, step: int) -> list[tuple[Topic, bytes]]:
        """Take in what has arrived, for step `step`. Returns the messages that were accepted."""
        accepted = []
        for index, data in self.inbox.take():
            topic = self.topics[index]
            try:
                self._receive(world, index, topic, data, step)
            except RefusedInputError as error:
                self.counters["refused"] += 1
                self.counters[error.counter] += 1
                self._complain(topic.name, str(error))
            else:
                self.counters["accepted"] += 1
                accepted.append((topic, data))
        return accepted

    def _receive(self, world: Any, index: int, topic: Topic, data: bytes, step: int) -> None:
        decode = {
            "wrench": decode_wrench_stamped,
            "cmd_pose": decode_pose_stamped,
            "cmd_vel": decode_twist_stamped,
        }[topic.content]
        try:
            message = decode(data)
        except ValueError as error:
            raise MalformedMessageError(f"message on {topic.name} refused: {error}") from None
        values, body = message.values, str(topic.body)
        if topic.content == "wrench":
            source = self._sources[index]
            wrench = self.wrenches.resolve(source, message.frame_id, values[:3], values[3:])
            if self.lockstep is not None:
                start_ns = round(world.time * 1e9)
                self.lockstep.admit(source, topic.name, message.time_ns, start_ns)
            self.wrenches.hold(source, wrench)
        elif topic.content == "cmd_pose":
            self.motions.receive_pose(
                world, body, message.frame_id, values, message.time_ns * 1e-9, step
            )
        else:
            self.motions.receive_twist(body, message.frame_id, values, step)

    def apply(self, world: Any, step: int, perform: Perform) -> None:
        """Let everything received act from step `step` on."""
        self.wrenches.apply(step, perform)
        self.motions.apply(world, step, perform)

    def clear(self, step: int, perform: Perform) -> None:
        """Forget everything commanded so far, messages that still wait included."""
        self.counters["discarded_by_reset"] += len(self.inbox.take())
        self.wrenches.clear(step, perform)
        self.motions.clear(perform)
        if self.lockstep is not None:
            self.lockstep.next_step()
