"""The topics of the simulator, from a file such as msg_configs/topics.yaml. No ROS in here.

`load_topics` reads and checks the file; `TopicTable.expand` turns its entries into the concrete
topics of a set of bodies. Node and recorder use the same table.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

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
        Raises TopicError for a body or frame that doesn't exist and for two topics of one name;
        with `strict` False, bodies being added and removed, what lacks its body or frame is left
        out.
        """
        known = {body.name: body for body in bodies}
        topics: list[Topic] = []
        seen: dict[tuple[str, str], TopicEntry] = {}
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
                first = seen.setdefault((topic.direction, topic.name), entry)
                if first is not entry:
                    raise TopicError(
                        f"{self.source}:{entry.line}: topic {topic.name} is already defined in line "
                        f"{first.line}"
                    )
                topics.append(topic)
        return topics

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
            return [name for name, body in known.items() if body.type in _KINDS[chosen]]
        for name in chosen:
            if strict and name not in known:
                raise TopicError(
                    f"{self.source}:{entry.line}: {field_name}: there is no body {name!r}; "
                    f"known: {', '.join(known) or 'none'}"
                )
        return [name for name in chosen if name in known]

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
    path = default_topics_path() if path is None else Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TopicError(f"{path}: the topics file can't be read: {error}") from None
    return parse_topics(text, str(path))


def parse_topics(text: str, source: str = "topics.yaml") -> TopicTable:
    """Checks the text of a topics file. TopicError names line, field and what is allowed."""
    import jsonschema

    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = mark.line + 1 if mark else 1
        problem = getattr(error, "problem", error)
        raise TopicError(f"{source}:{line}: not valid YAML: {problem}") from None
    if root is None:
        raise TopicError(f"{source}:1: the file is empty; it needs a list 'topics'")
    schema = json.loads(Path(__file__).with_name("topics.schema.json").read_text(encoding="utf-8"))
    errors = jsonschema.Draft202012Validator(schema).iter_errors(data)
    for wrong in sorted(errors, key=lambda e: [str(p) for p in e.absolute_path]):
        where = ".".join(str(p) for p in wrong.absolute_path) or "file"
        raise TopicError(
            f"{source}:{_line(root, list(wrong.absolute_path))}: {where}: {_reason(wrong)}"
        )
    entries = []
    for i, raw in enumerate(data["topics"]):
        entries.append(_entry(raw, source, _line(root, ["topics", i])))
    return TopicTable(tuple(entries), source)


def _reason(error: Any) -> str:
    if error.validator == "enum":
        allowed = ", ".join(str(v) for v in error.validator_value)
        return f"{error.instance!r} is not one of {allowed}"
    if error.validator == "pattern":
        return f"{error.instance!r} is not a topic name such as /clock or ~/poses"
    if error.validator == "oneOf":
        return f"{error.instance!r} is neither a list of body names nor *, dynamic, kinematic, all"
    return str(error.message)


def _line(node: Any, path: list[Any]) -> int:
    """The line of the value at `path`, as far as the path exists in the document."""
    for part in path:
        if isinstance(node, yaml.MappingNode):
            child = next((v for k, v in node.value if k.value == part), None)
        elif isinstance(node, yaml.SequenceNode) and isinstance(part, int):
            child = node.value[part]
        else:
            child = None
        if child is None:
            break
        node = child
    return int(node.start_mark.line) + 1


def _entry(raw: dict[str, Any], source: str, line: int) -> TopicEntry:
    content = raw["content"]
    message_type, direction, per_body = CONTENT[content]
    where = f"{source}:{line}: {raw['name']}"
    parts = raw["name"].split("/")
    if raw["type"] != message_type:
        raise TopicError(f"{where}: type: {content} is sent as {message_type}, not {raw['type']}")
    if raw["direction"] != direction:
        raise TopicError(f"{where}: direction: {content} goes {direction}, not {raw['direction']}")
    if per_body != ("NAME" in parts):
        rule = "needs a part NAME, one topic per body" if per_body else "can't hold NAME"
        raise TopicError(f"{where}: name: a topic of content {content} {rule}")
    if (content == "pair_wrench") != ("OTHER" in parts):
        rule = "needs a part OTHER" if content == "pair_wrench" else "can't hold OTHER"
        raise TopicError(f"{where}: name: a topic of content {content} {rule}")
    if "bodies" in raw and not per_body and content != "cmd_tf":
        raise TopicError(f"{where}: bodies: {content} is one topic for all bodies; leave it out")
    for only, contents in (("others", ("pair_wrench",)), ("reference_point", SENSORS)):
        if only in raw and content not in contents:
            raise TopicError(f"{where}: {only}: {content} has none; leave it out")
    frame = raw.get("frame", "NAME" if content == "cmd_tf" else _FRAMES.get(content, ("",))[0])
    _check_frame(frame, content, where, "frame")
    reference_point = raw.get("reference_point", "NAME/com" if frame == "world" else frame)
    if content in SENSORS:
        _check_frame(reference_point, content, where, "reference_point")
    rate = float(raw.get("rate", 0.0))
    if not math.isfinite(rate):
        raise TopicError(f"{where}: rate: {rate} is not a finite number of Hz")
    if "rate" in raw and (direction == "in" or content in LATCHED):
        raise TopicError(f"{where}: rate: {content} is not sent at a rate; leave it out")
    default = "kinematic" if content == "cmd_tf" else "*"
    return TopicEntry(raw["name"], content, message_type, direction, frame, rate,
                      Qos(**raw.get("qos", {})), _names(raw.get("bodies", default)), line,
                      _names(raw.get("others", "all")),
                      reference_point if content in SENSORS else "")  # fmt: skip


def _check_frame(frame: str, content: str, where: str, field_name: str) -> None:
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
    raise TopicError(f"{where}: {field_name}: {frame!r} for {content}; allowed: {allowed}")


def _names(chosen: str | list[str]) -> str | tuple[str, ...]:
    return chosen if isinstance(chosen, str) else tuple(chosen)
