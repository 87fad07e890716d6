"""The topics of the simulator, from a file such as msg_configs/topics.yaml. No ROS in here.

`load_topics` reads and checks the file; `TopicTable.expand` turns its entries into the concrete
topics of a set of bodies. Node and recorder use the same table.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn

from .. import located_yaml
from ..located_yaml import Document
from ..resources import shared_folder

# What each content is sent as, its direction, and whether it is one topic per body.
CONTENT = {
    "clock": ("rosgraph_msgs/msg/Clock", "out", False),
    "poses": ("geometry_msgs/msg/PoseArray", "out", False),
    "body_names": ("std_msgs/msg/String", "out", False),
    "pose": ("geometry_msgs/msg/PoseStamped", "out", True),
    "odometry": ("nav_msgs/msg/Odometry", "out", True),
    "contact_wrench": ("geometry_msgs/msg/WrenchStamped", "out", True),
    "pair_wrench": ("geometry_msgs/msg/WrenchStamped", "out", True),
    "contacts": ("sensor_msgs/msg/PointCloud2", "out", False),
    "markers": ("visualization_msgs/msg/MarkerArray", "out", False),
    "totals": ("std_msgs/msg/Float64MultiArray", "out", False),
    "diagnostics": ("diagnostic_msgs/msg/DiagnosticArray", "out", False),
    "tf": ("tf2_msgs/msg/TFMessage", "out", False),
    "tf_static": ("tf2_msgs/msg/TFMessage", "out", False),
    "robot_description": ("std_msgs/msg/String", "out", False),
    "wrench": ("geometry_msgs/msg/WrenchStamped", "in", True),
    "wrenches": ("sensor_msgs/msg/MultiDOFJointState", "in", False),
    "cmd_pose": ("geometry_msgs/msg/PoseStamped", "in", True),
    "cmd_vel": ("geometry_msgs/msg/TwistStamped", "in", True),
    "cmd_tf": ("tf2_msgs/msg/TFMessage", "in", False),
    "spawn": ("std_msgs/msg/String", "in", False),
    "remove": ("std_msgs/msg/String", "in", False),
    "change": ("std_msgs/msg/String", "in", False),
}
# Header frames an output can be expressed in; the first is the default. Contact wrenches take any
# frame of any body as well, and so does their reference point.
_FRAMES = {
    "poses": ("world",),
    "pose": ("world",),
    "odometry": ("world",),
    "contact_wrench": ("NAME/com", "NAME", "world"),
    "pair_wrench": ("NAME/com", "NAME", "world"),
    "contacts": ("world",),
    "markers": ("world",),
    "tf": ("world",),
}
SENSORS = ("contact_wrench", "pair_wrench")
_SENSOR_FRAME = re.compile(r"world|[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)?")
_LINK_FRAME = re.compile(r"[A-Za-z0-9_/.-]*NAME[A-Za-z0-9_/.-]*")  # of cmd_tf
# Inputs that act on bodies of one type only.
NEEDED_TYPE = {
    "wrench": "dynamic",
    "cmd_pose": "kinematic",
    "cmd_vel": "kinematic",
    "cmd_tf": "kinematic",
}
LATCHED = ("body_names", "tf_static", "robot_description")  # sent at the start and on change


class TopicError(ValueError):
    """A topics file that can't be used; says which line and field, and what is allowed."""


@dataclass(frozen=True)
class Qos:
    """Quality of service, in the words of ROS 2."""

    reliability: str = "reliable"
    durability: str = "volatile"
    history: str = "keep_last"
    depth: int = 10


@dataclass(frozen=True)
class Topic:
    """One concrete topic. `body` is None unless there is one topic per body."""

    name: str  # full name, e.g. /sim_node/bodies/box/pose
    content: str  # a key of CONTENT
    type: str  # ROS message type, e.g. geometry_msgs/msg/PoseStamped
    direction: str  # "in" or "out"
    frame: str = ""  # header.frame_id, e.g. world or box/com; "" where the type has none
    rate: float = 0.0  # Hz of simulation time; 0: every step, or on change for LATCHED contents
    qos: Qos = field(default_factory=Qos)
    body: str | None = None
    other: str | None = None  # pair_wrench: the body whose contacts with `body` count
    reference_point: str = ""  # contact wrenches: frame whose origin the torque is about
    bodies: tuple[str, ...] = ()  # cmd_tf: the bodies it drives


LONGEST_NAME = 247  # characters of a topic's name, which ROS takes
# Below the node: what it publishes or logs without an entry.
RESERVED = ("bodies", "state_hash", "snapshots", "operations", "held_wrenches", "events")
_SHARED = ("tf", "tf_static", "cmd_tf")  # many publish and read these topics


@dataclass(frozen=True)
class TopicEntry:
    """One entry of a topics file; `name` may hold NAME and start with ~/."""

    name: str
    content: str
    type: str
    direction: str
    frame: str
    rate: float
    qos: Qos
    bodies: str | tuple[str, ...]
    line: int
    others: str | tuple[str, ...] = ()
    reference_point: str = ""


@dataclass(frozen=True)
class TopicTable:
    """The entries of a topics file, in its order."""

    entries: tuple[TopicEntry, ...]
    source: str = ""

    def expand(
        self, bodies: Iterable[Any], node_name: str = "sim_node", *, strict: bool = True
    ) -> list[Topic]:
        """The concrete topics for `bodies` (each with .name, .type, .frames), in the file's order.

        "*" stands for the dynamic and kinematic bodies, "dynamic", "kinematic" and "all" for those.
        Raises TopicError for a body or frame that doesn't exist, a body of a type that can't take
        the input, and two topics of one name; with `strict` False, bodies being added and removed,
        what lacks its body or frame is left out.
        """
        known = {body.name: body for body in bodies}
        topics: list[Topic] = []
        seen: dict[str, TopicEntry] = {}
        follows_tf = any(e.content == "cmd_tf" and e.bodies != () for e in self.entries)
        for entry in self.entries:
            if entry.content == "cmd_tf" and not follows_tf:
                continue
            for body, other in self._chosen(entry, known, strict):
                topic = self._topic(entry, body, other, node_name)
                if entry.content == "cmd_tf":
                    driven = self._named(entry, entry.bodies, "bodies", known, strict)
                    topic = replace(topic, bodies=tuple(driven))
                if not self._has_frames(entry, topic, known, strict):
                    continue
                if len(topic.name) > LONGEST_NAME and strict:
                    raise TopicError(
                        f"{self.source}:{entry.line}: topic {topic.name[:40]}… has {len(topic.name)} "
                        f"characters; ROS takes {LONGEST_NAME}: shorten it, or the name of the body"
                    )
                once = "" if entry.content not in _SHARED else topic.direction
                first = seen.setdefault(once + topic.name, entry)
                if first is not entry:
                    raise TopicError(
                        f"{self.source}:{entry.line}: topic {topic.name} is already defined in line "
                        f"{first.line}"
                    )
                topics.append(topic)
        return topics

    def check_name(self, body: str, node_name: str, taken: Collection[str]) -> None:
        """Raises TopicError for the name of a body whose topics ROS would not take, or are `taken`."""
        for entry in self.entries:
            if CONTENT[entry.content][2]:
                name = self._topic(entry, body, body, node_name).name
                own = name.removeprefix("/" + node_name.strip("/") + "/")
                if name in taken or own in RESERVED:
                    raise TopicError(
                        f"a body named {body} would have the topic {name}, which is another one "
                        "already: choose another name"
                    )
                length = len(name)
                if length > LONGEST_NAME:
                    raise TopicError(
                        f"the name {body[:20]}… of a body has {len(body)} characters, so that its topic "
                        f"{entry.name} would have {length}, and ROS takes {LONGEST_NAME}: choose a "
                        "shorter one"
                    )

    def _topic(
        self, entry: TopicEntry, body: str | None, other: str | None, node_name: str
    ) -> Topic:
        def fill(text: str) -> str:
            words = {"NAME": body or "NAME", "OTHER": other or "OTHER"}
            return "/".join(words.get(part, part) for part in text.split("/"))

        name = fill(entry.name.replace("~", "/" + node_name.strip("/"), 1))
        return Topic(name, entry.content, entry.type, entry.direction, fill(entry.frame),
                     entry.rate, entry.qos, body, other, fill(entry.reference_point))  # fmt: skip

    def _chosen(
        self, entry: TopicEntry, known: dict[str, Any], strict: bool
    ) -> list[tuple[str | None, str | None]]:
        """The bodies (and for pairs the other ones) that get a topic of an entry."""
        if not CONTENT[entry.content][2]:
            return [(None, None)]
        names = self._named(entry, entry.bodies, "bodies", known, strict)
        if entry.content != "pair_wrench":
            return [(name, None) for name in names]
        others = self._named(entry, entry.others, "others", known, strict)
        return [(name, other) for name in names for other in others if other != name]

    def _named(
        self,
        entry: TopicEntry,
        chosen: str | tuple[str, ...],
        field_name: str,
        known: dict[str, Any],
        strict: bool,
    ) -> list[str]:
        if isinstance(chosen, str):
            names = [name for name, body in known.items() if body.type in _KINDS[chosen]]
        else:
            names = [name for name in chosen if name in known]
            if strict and len(names) < len(chosen):
                unknown = next(name for name in chosen if name not in known)
                raise TopicError(
                    f"{self.source}:{entry.line}: {field_name}: there is no body {unknown!r}; "
                    f"known: {', '.join(known) or 'none'}"
                )
        needed = NEEDED_TYPE.get(entry.content)
        fitting = [name for name in names if needed in (None, known[name].type)]
        if strict and len(fitting) < len(names):
            wrong = next(name for name in names if name not in fitting)
            raise TopicError(
                f"{self.source}:{entry.line}: topic {entry.name} is for a {needed} body, but "
                f"'{wrong}' is {known[wrong].type}: take it out of `bodies` in topics.yaml"
            )
        return fitting

    def _has_frames(
        self, entry: TopicEntry, topic: Topic, known: dict[str, Any], strict: bool
    ) -> bool:
        if topic.content not in SENSORS:
            return True
        for field_name in ("frame", "reference_point"):
            frame = getattr(topic, field_name)
            name, _, part = frame.partition("/")
            if frame in ("", "world"):
                continue
            frames = getattr(known.get(name), "frames", {})
            if name in known and (part in ("", "com") or part in frames):
                continue
            if strict:
                valid = [f"{name}/{part}" for part in ("com", *frames)] if name in known else known
                raise TopicError(
                    f"{self.source}:{entry.line}: {field_name}: there is no frame '{frame}'; "
                    f"known: world, {', '.join(valid)}"
                )
            return False
        return True


_KINDS = {
    "*": ("dynamic", "kinematic"),
    "all": ("dynamic", "kinematic", "static"),
    "dynamic": ("dynamic",),
    "kinematic": ("kinematic",),
}


def topic_lines(topics: Sequence[Topic]) -> list[str]:
    """A table of topics for people: direction, name, type, frame, rate, quality of service."""
    rows = [("", "topic", "type", "frame", "rate", "qos")]
    for topic in topics:
        if topic.direction == "in" or topic.content in LATCHED:
            rate = "" if topic.direction == "in" else "on change"
        else:
            rate = f"{topic.rate:g} Hz" if topic.rate else "every step"
        frame = topic.frame
        if topic.reference_point not in ("", frame):
            frame += f" about {topic.reference_point}"
        if topic.content == "cmd_tf":
            frame = ", ".join(frame.replace("NAME", body) for body in topic.bodies)
        qos = f"{topic.qos.reliability} {topic.qos.durability} {topic.qos.depth}"
        rows.append((topic.direction, topic.name, topic.type, frame, rate, qos))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def default_topics_path() -> Path:
    """The packaged msg_configs/topics.yaml. Raises FileNotFoundError."""
    return shared_folder("msg_configs") / "topics.yaml"


def load_topics(path: str | Path | None = None) -> TopicTable:
    """Reads and checks a topics file (None: the packaged one). Raises TopicError."""
    if not isinstance(path, (str, Path, type(None))):
        raise TopicError(f"path is {path!r}; it must be the path of a topics file, or None")
    path = default_topics_path() if path is None else Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TopicError(f"{path}: the topics file can't be read: {error}") from None
    return parse_topics(text, str(path))


def parse_topics(text: str, source: str = "topics.yaml") -> TopicTable:
    """Checks the text of a topics file. TopicError names line, field and what is allowed."""
    schema = json.loads(Path(__file__).with_name("topics.schema.json").read_text(encoding="utf-8"))
    try:
        document = located_yaml.parse(text, source, schema, _subject)
    except ValueError as error:
        if str(error).endswith("the file is empty"):
            error = ValueError(f"{source}:1: the file is empty; it needs a list 'topics'")
        raise TopicError(str(error)) from None
    rows = range(len(document.data["topics"]))
    return TopicTable(tuple(_entry(document, row) for row in rows), source)


def _subject(data: Any, path: tuple[str | int, ...]) -> tuple[str, tuple[str | int, ...]]:
    """Splits ``topics[3].rate`` into ``topic ~/poses`` and ``rate`` for messages."""
    if len(path) < 3 or path[0] != "topics" or path[2] == "name":
        return "", path
    topic = data["topics"][path[1]]
    name = topic.get("name") if isinstance(topic, dict) else None
    return (f"topic {name}", path[2:]) if isinstance(name, str) else ("", path)


def _entry(document: Document, row: int) -> TopicEntry:
    raw: dict[str, Any] = document.data["topics"][row]
    content = raw["content"]
    message_type, direction, per_body = CONTENT[content]
    parts = raw["name"].split("/")

    def refuse(field_name: str, sentence: str) -> NoReturn:
        line = document.line(("topics", row, field_name))
        raise TopicError(f"{document.name}:{line}: topic {raw['name']}: {field_name}: {sentence}")

    if raw["name"].startswith("~/") and raw["name"][2:] in RESERVED:
        refuse("name", "is one of the node's and the log's own; choose another")
    if raw["type"] != message_type:
        refuse("type", f"{content} is sent as {message_type}, not {raw['type']}")
    if raw["direction"] != direction:
        refuse("direction", f"{content} goes {direction}, not {raw['direction']}")
    if per_body != ("NAME" in parts):
        rule = "needs a part NAME, one topic per body" if per_body else "can't hold NAME"
        refuse("name", f"a topic of content {content} {rule}")
    if (content == "pair_wrench") != ("OTHER" in parts):
        rule = "needs a part OTHER" if content == "pair_wrench" else "can't hold OTHER"
        refuse("name", f"a topic of content {content} {rule}")
    if "bodies" in raw and not per_body and content != "cmd_tf":
        refuse("bodies", f"{content} is one topic for all bodies; leave it out")
    for only, contents in (("others", ("pair_wrench",)), ("reference_point", SENSORS)):
        if only in raw and content not in contents:
            refuse(only, f"{content} has none; leave it out")
    frame = raw.get("frame", "NAME" if content == "cmd_tf" else _FRAMES.get(content, ("",))[0])
    _check_frame(frame, content, "frame", refuse)
    reference_point = raw.get("reference_point", "NAME/com" if frame == "world" else frame)
    if content in SENSORS:
        _check_frame(reference_point, content, "reference_point", refuse)
    if "rate" in raw and (direction == "in" or content in LATCHED):
        refuse("rate", f"{content} is not sent at a rate; leave it out")
    default = NEEDED_TYPE.get(content, "*")
    return TopicEntry(raw["name"], content, message_type, direction, frame,
                      float(raw.get("rate", 0.0)), Qos(**raw.get("qos", {})),
                      _names(raw.get("bodies", default)), document.line(("topics", row)),
                      _names(raw.get("others", "all")),
                      reference_point if content in SENSORS else "")  # fmt: skip


def _check_frame(
    frame: str, content: str, field_name: str, refuse: Callable[[str, str], NoReturn]
) -> None:
    if content in SENSORS:
        if _SENSOR_FRAME.fullmatch(frame):
            return
        allowed = "world, NAME, NAME/com, NAME/FRAME or such a frame of a body by its name"
    elif content == "cmd_tf":
        if _LINK_FRAME.fullmatch(frame):
            return
        allowed = "the name of the body's frame with NAME in it, such as robot/NAME"
    else:
        frames = _FRAMES.get(content, ("",))
        if frame in frames:
            return
        allowed = " or ".join(f for f in frames if f) or "none: leave it out"
    refuse(field_name, f"{frame!r} for {content}; allowed: {allowed}")


def _names(chosen: str | list[str]) -> str | tuple[str, ...]:
    return chosen if isinstance(chosen, str) else tuple(chosen)
