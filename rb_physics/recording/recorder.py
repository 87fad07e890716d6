"""The recorder: one world, its outputs and inputs, into a bag and a Rerun view."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from . import encoders
from .environment import notes_of_run
from .geometry import to_json as bodies_to_json
from .mcap_log import Attachment, McapLog
from .message_queue import Entry
from .operations import CHANGE_BODIES, RESETS, Operation, Operations, plain
from .operations import to_json as operation_to_json
from .outputs import Message, Outputs
from .recorder_arguments import check_log_options, checked
from .topics import Qos, TopicTable, load_topics

# 2: the state hash in eight lanes; coefficients of friction in `bodies`. 1 can be read, viewed and
# exported, but not repeated.
FORMAT_VERSION = 2
_HASH_BATCH = 0.02  # s of simulated or wall time after which state hashes are written
_VIEW_ROOM = (
    1_200_000  # bytes: where the bag stops for lack of room, the view needs some for its end
)
_LATCHED_QOS = Qos(durability="transient_local", depth=1)
# What the recorder adds to the node's topics: name below the node, type, whether it may be dropped.
_OWN_TOPICS = {
    "bodies": ("std_msgs/msg/String", _LATCHED_QOS),
    "state_hash": ("std_msgs/msg/UInt64MultiArray", Qos()),
    "snapshots": ("std_msgs/msg/UInt8MultiArray", Qos()),
    "operations": ("std_msgs/msg/String", Qos()),
    "held_wrenches": ("std_msgs/msg/String", _LATCHED_QOS),
    "events": ("std_msgs/msg/String", Qos()),
}
EVENT_LEVELS = ("INFO", "WARN", "ERROR")


class Recorder:
    """Encodes and logs what a world sends and receives. A context manager.

    Beside the topics of the table the bag holds, below the node's namespace:

    - ``bodies``: the bodies as drawn (JSON), at the start and when bodies come or go;
    - ``state_hash``: rows (step, hash) of every step since the last message;
    - ``snapshots``: ``world.save()``, at the start and every `snapshot_interval` s; the label of
      the one dimension is ``step N``;
    - ``operations``: every change of the world (see operations.py);
    - ``held_wrenches``: what is applied already at the start (of a branch);
    - ``events``: lines for people: "LEVEL text".

    Steps count from the start of the recording and go on through resets. The MCAP field `sequence`
    of every message is that number. log_time is simulated time plus an offset raised at each
    reset, so that it never goes back.
    """

    def __init__(
        self,
        world: Any,
        directory: str | Path | None,
        *,
        scene: Any = None,
        topics: TopicTable | None = None,
        node_name: str = "sim_node",
        rerun: str = "off",
        snapshot_interval: float = 5.0,
        custom_data: dict[str, str] | None = None,
        initial: bytes | None = None,
        first: Sequence[tuple[str, Mapping[str, Any]]] = (),
        log_start: int | None = None,
        held_wrenches: str | None = None,
        **log_options: Any,
    ) -> None:
        """Args:
            directory: a new folder; None records nothing, outputs are still encoded.
            scene: the `Scene` the world was built from; stored, so that the run can be repeated.
            topics: None: the packaged table.
            rerun: "off", "file" (a .rrd in the folder), or "live" (a viewer too).
            snapshot_interval: s of simulated time, > 0.
            custom_data: further notes.
            initial: the snapshot `reset` goes back to; None: the present state.
            first: operations (name, arguments) that are performed before the first outputs.
            log_start: steps of log time at the start; None: as many as the world has made.
            held_wrenches: those that the world has at the start (`HeldWrenches.to_json`), for views.
            log_options: those of `McapLog` (compression, policy, split_bytes, ...).

        Raises RecordingError, TopicError, and what an operation of `first` raises; then nothing is
        left behind.
        """
        snapshot_interval = checked(
            world, directory, scene, topics, node_name, rerun, snapshot_interval, custom_data,
            initial, first, log_start, held_wrenches,
        )  # fmt: skip
        check_log_options(log_options)
        self._world = world
        self.outputs = Outputs(world, topics if topics is not None else load_topics(), node_name)
        self._operations = Operations(world, initial)
        self._namespace = "/" + node_name.strip("/") + "/"
        self.outputs.worst.open(self)
        self.step = 0  # steps made since the start
        self._counted = int(world.step_count)
        self._time_offset = 0  # ns, log time minus simulated time
        self._last_log_time = 0
        self._log: McapLog | None = None
        self._view: Any = None
        self._ids: dict[str, int] = {}  # topic name -> id in the log
        self._contents: list[tuple[str, str | None]] = []  # of each id: content and body
        if directory is None:
            return
        folder = Path(directory)
        attachments = [Attachment("topics.json", "application/json", _topics_text(self.outputs))]
        notes = notes_of_run(world, scene, node_name, FORMAT_VERSION) | (custom_data or {})
        if log_start is not None:
            notes["first_step"] = str(log_start)
            self._time_offset = round(log_start * world.settings.dt * 1e9) - round(world.time * 1e9)
        if scene is not None:
            text = scene.to_yaml().encode()
            attachments.insert(0, Attachment("scene.yaml", "application/yaml", text))
        if initial is not None:
            attachments.append(Attachment("initial.snapshot", "application/octet-stream", initial))
        if rerun != "off":
            from . import rerun_log

            # Before the folder exists: a missing Rerun or viewer leaves nothing behind.
            rerun_log.require(live=rerun == "live")
        self._log = McapLog(folder, custom_data=notes, attachments=attachments, **log_options)
        try:
            self._begin(rerun, snapshot_interval, first, held_wrenches)
        except BaseException:
            if self._view is not None:
                self._view.close()
            self._log.discard([_rrd_name(folder)])
            raise

    def _begin(
        self,
        rerun: str,
        snapshot_interval: float,
        first: Sequence[tuple[str, Mapping[str, Any]]],
        held_wrenches: str | None,
    ) -> None:
        """The view, and what is written at the start."""
        assert self._log is not None
        world, folder = self._world, self._log.directory
        if rerun != "off":
            from .rerun_log import RerunLog
            from .rerun_sink import RerunSink

            self._log.check_room(_VIEW_ROOM)
            path = folder / _rrd_name(folder)
            self._view = RerunSink(RerunLog(path, asdict(world.settings), live=rerun == "live"))
        world.keep_hashes = True
        world.drain_hashes()
        self._hashes: list[tuple[int, int]] = []
        self._hash_encoder = encoders.MultiArrayEncoder(
            ("step", "step hash"), "std_msgs/msg/UInt64MultiArray"
        )
        self._hash_due_ns, self._hash_due_wall = 0.0, 0.0
        self._snapshot_ns = snapshot_interval * 1e9
        self._register_topics()
        self._write_start(first, held_wrenches)

    # -- the run ----------------------------------------------------------------------------------

    def after_step(self, send: Callable[[list[Message]], None] | None = None) -> list[Message]:
        """Call after one or several steps: logs what they did, returns the outputs that are due.

        `send` gets them before they are logged: a reader waits for them, the log does not."""
        messages = self.outputs.collect()
        if send is not None:
            send(messages)
        if self._log is None:
            self._count()
            return messages
        hashes = self._world.drain_hashes().tolist()
        first, self.step = self.step, self.step + len(hashes)
        self._counted = int(self._world.step_count)
        self._hashes.extend(enumerate(hashes, first + 1))
        now = self._now()
        entries = [self._entry(name, now, data) for name, data in messages]
        if now >= self._hash_due_ns or time.monotonic() >= self._hash_due_wall:
            entries.extend(self._take_hashes(now))
        if now >= self._next_snapshot_ns:
            entries.append(self._snapshot(now))
        if entries:
            self._write(entries)
        return messages

    def perform(self, name: str, **arguments: Any) -> str:
        """Changes the world and logs it; the JSON that is logged. Raises what the world raises; then
        nothing is logged."""
        arguments = plain(arguments)
        text = operation_to_json(Operation(self.step, name, arguments))
        before = self._world.bodies
        self._operations.perform(name, arguments)
        others = name in CHANGE_BODIES and self._world.bodies != before
        if others:
            self.outputs.rebuild()
        if name in RESETS:
            self.outputs.restart()
            self._counted = int(self._world.step_count)
        if self._log is None:
            return text
        now = self._now()
        entries = [*self._take_hashes(now), self._own("operations", now, text)]
        if others:
            self._register_topics()
            entries.extend(self._description(now))
        self._write(entries)
        if name in RESETS:
            self.event("INFO", f"{name} at step {self.step}")
        return text

    @property
    def spawned(self) -> tuple[str, ...]:
        """Names of the bodies added since the start and still there."""
        return self._operations.spawned

    def _count(self) -> None:
        """Steps made, when no hashes tell."""
        now = int(self._world.step_count)
        self.step += now - self._counted
        self._counted = now

    def write_input(self, topic: str, data: bytes) -> None:
        """Logs a received message of an input topic of the table, as it came."""
        if self._log is not None:
            self._write([self._entry(topic, self._now(), data)])

    def event(self, level: str, text: str) -> None:
        """A line for people, in the log and in the view."""
        if level not in EVENT_LEVELS:
            raise ValueError(f"level {level!r} is not one of {', '.join(EVENT_LEVELS)}")
        if self._log is not None:
            line = f"{level} {text}".replace("\0", "")
            self._write([self._own("events", self._now(), line)])

    def latched(self) -> list[Message]:
        """Messages of the transient_local topics, to be sent at the start."""
        return self.outputs.latched()

    def steps_until_due(self) -> int:
        """Steps that may be made before the next `after_step` sends something; at least 1."""
        return self.outputs.steps_until_due()

    # -- state of the recording -------------------------------------------------------------------

    @property
    def directory(self) -> Path | None:
        return self._log.directory if self._log is not None else None

    @property
    def error(self) -> str | None:
        """Why recording stopped, as one sentence; None while it works (or nothing is recorded)."""
        return self._log.error if self._log is not None else None

    @property
    def view_error(self) -> str | None:
        """Why the Rerun view stopped, as one sentence; the bag goes on without it, not it without
        the bag."""
        return self._view.error if self._view is not None else None

    @property
    def counters(self) -> dict[str, int]:
        """Messages and bytes written, dropped and queued; empty when nothing is recorded."""
        if self._log is None:
            return {}
        counters = self._log.counters
        if self._view is not None:
            counters["view_dropped"] = self._view.dropped
        return counters

    def close(self) -> None:
        """Ends the recording; everything given before is in it. Safe to call again."""
        if self._log is None:
            return
        if not self._log.closed:
            self._write(self._take_hashes(self._now()))
        self._log.close(
            {"steps": str(self.step), "worst_steps": json.dumps(self.outputs.worst.take(self))}
        )
        if self._view is not None:
            self._view.close()

    def abandon(self) -> None:
        """Ends the recording without a look at the world, which may be in the midst of a step."""
        if self._log is not None:
            if not self._log.closed:
                self._write(self._take_hashes(self._last_log_time))
            self._log.close({"steps": str(self.step)})
            if self._view is not None:
                self._view.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- entries ----------------------------------------------------------------------------------

    def _register_topics(self) -> None:
        log = self._log
        assert log is not None
        for name, (type_name, qos) in _OWN_TOPICS.items():
            self._add_topic((name, None), self._namespace + name, type_name, qos, True)
        for topic in self.outputs.topics:
            content = (topic.content, topic.body)
            self._add_topic(content, topic.name, topic.type, topic.qos, topic.direction == "in")

    def _add_topic(
        self, content: tuple[str, str | None], name: str, type_name: str, qos: Qos, essential: bool
    ) -> None:
        if name not in self._ids and self._log is not None:
            self._ids[name] = self._log.add_topic(name, type_name, qos, essential)
            self._contents.append(content)

    def _write_start(
        self, first: Sequence[tuple[str, Mapping[str, Any]]], held_wrenches: str | None
    ) -> None:
        now = self._now()
        self._write([*self._description(now), self._snapshot(now)])
        for name, arguments in first:
            self.perform(name, **arguments)
        now = self._now()
        if held_wrenches is not None:
            self._write([self._own("held_wrenches", now, held_wrenches)])
        outputs = self.outputs.collect(everything=True)
        self._write([self._entry(name, now, data) for name, data in outputs])

    def _description(self, now: int) -> list[Entry]:
        """What the bodies are: for views, and what viewers need from latched topics."""
        entries = [self._own("bodies", now, bodies_to_json(self.outputs.bodies))]
        return entries + [self._entry(n, now, d) for n, d in self.outputs.latched()]

    def _snapshot(self, now: int) -> Entry:
        self._next_snapshot_ns = now + self._snapshot_ns
        data = np.frombuffer(self._world.save(), np.uint8)
        encoder = encoders.MultiArrayEncoder((f"step {self.step}",), "std_msgs/msg/UInt8MultiArray")
        return self._entry(self._namespace + "snapshots", now, encoder.encode(data))

    def _take_hashes(self, now: int) -> list[Entry]:
        self._hash_due_ns = now + _HASH_BATCH * 1e9
        self._hash_due_wall = time.monotonic() + _HASH_BATCH
        if not self._hashes:
            return []
        rows = np.array(self._hashes, np.uint64)
        self._hashes = []
        return [self._entry(self._namespace + "state_hash", now, self._hash_encoder.encode(rows))]

    def _own(self, name: str, now: int, text: str) -> Entry:
        return self._entry(self._namespace + name, now, encoders.encode_string(text))

    def _now(self) -> int:
        """The log time: simulated time that never goes back."""
        now: float = self._world.time
        log_time = round(now * 1e9) + self._time_offset
        if log_time < self._last_log_time:
            self._time_offset += self._last_log_time - log_time
            log_time = self._last_log_time
            self._hash_due_ns = self._next_snapshot_ns = 0.0
        self._last_log_time = log_time
        return log_time

    def _entry(self, name: str, now: int, data: bytes) -> Entry:
        try:
            return Entry(self._ids[name], now, self.step, data)
        except KeyError:
            raise ValueError(f"topic {name} is not in the table of topics") from None

    def _write(self, entries: list[Entry]) -> None:
        assert self._log is not None
        self._log.write(entries)
        if self._view is None:
            return
        if self._log.error is not None:
            # Its file is on the same disk, and a full one can leave Rerun waiting for its own
            # writer for ever: it ends while there is room.
            self._view.end()
        else:
            self._view.write([(*self._contents[e.topic], e.log_time, e.data) for e in entries])


def _rrd_name(folder: Path) -> str:
    return f"{folder.name}.rrd"


def _topics_text(outputs: Outputs) -> bytes:
    return json.dumps([asdict(topic) for topic in outputs.topics]).encode()
