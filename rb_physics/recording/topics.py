"""The topics of the simulator, from a file such as msg_configs/topics.yaml. No ROS in here.

`load_topics` reads and checks the file; `TopicTable.expand` turns its entries into the concrete
topics of a set of bodies. Node and recorder use the same table.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
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
    "contacts": ("sensor_msgs/msg/PointCloud2", "out", False),
    "markers": ("visualization_msgs/msg/MarkerArray", "out", False),
    "totals": ("std_msgs/msg/Float64MultiArray", "out", False),
    "diagnostics": ("diagnostic_msgs/msg/DiagnosticArray", "out", False),
    "tf": ("tf2_msgs/msg/TFMessage", "out", False),
    "tf_static": ("tf2_msgs/msg/TFMessage", "out", False),
    "robot_description": ("std_msgs/msg/String", "out", False),
    "wrench": ("geometry_msgs/msg/WrenchStamped", "in", True),
    "cmd_pose": ("geometry_msgs/msg/PoseStamped", "in", True),
    "cmd_vel": ("geometry_msgs/msg/TwistStamped", "in", True),
}
_FRAMES = {  # header frames an output can be expressed in; the first is the default
    "poses": ("world",),
    "pose": ("world",),
    "odometry": ("world",),
    "contact_wrench": ("NAME/com", "NAME", "world"),
    "contacts": ("world",),
    "markers": ("world",),
    "tf": ("world",),
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


@dataclass(frozen=True)
class TopicTable:
    """The entries of a topics file, in its order."""

    entries: tuple[TopicEntry, ...]
    source: str = ""

    def expand(self, bodies: Iterable[Any], node_name: str = "sim_node") -> list[Topic]:
        """The concrete topics for `bodies` (each with .name and .type), in the file's order.

        "*" stands for the dynamic and kinematic bodies, "dynamic", "kinematic" and "all" for those.
        Raises TopicError for a body that doesn't exist and for two topics of one name.
        """
        types = {body.name: body.type for body in bodies}
        topics: list[Topic] = []
        seen: dict[str, int] = {}
        for entry in self.entries:
            for body in self._chosen(entry, types):
                name = entry.name.replace("~", "/" + node_name.strip("/"), 1)
                if body is not None:
                    name = "/".join(body if part == "NAME" else part for part in name.split("/"))
                if name in seen:
                    raise TopicError(
                        f"{self.source}:{entry.line}: topic {name} is already defined in line "
                        f"{seen[name]}"
                    )
                seen[name] = entry.line
                frame = entry.frame.replace("NAME", body or "")
                topics.append(
                    Topic(name, entry.content, entry.type, entry.direction, frame, entry.rate,
                          entry.qos, body)
                )  # fmt: skip
        return topics

    def _chosen(self, entry: TopicEntry, types: dict[str, str]) -> Sequence[str | None]:
        if not CONTENT[entry.content][2]:
            return (None,)
        kinds = {
            "*": ("dynamic", "kinematic"),
            "all": ("dynamic", "kinematic", "static"),
            "dynamic": ("dynamic",),
            "kinematic": ("kinematic",),
        }
        if isinstance(entry.bodies, str):
            return [name for name, kind in types.items() if kind in kinds[entry.bodies]]
        for name in entry.bodies:
            if name not in types:
                raise TopicError(
                    f"{self.source}:{entry.line}: bodies: there is no body {name!r}; "
                    f"known: {', '.join(types) or 'none'}"
                )
        return entry.bodies


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
    if raw["type"] != message_type:
        raise TopicError(f"{where}: type: {content} is sent as {message_type}, not {raw['type']}")
    if raw["direction"] != direction:
        raise TopicError(f"{where}: direction: {content} goes {direction}, not {raw['direction']}")
    if per_body != ("NAME" in raw["name"].split("/")):
        rule = "needs a part NAME, one topic per body" if per_body else "can't hold NAME"
        raise TopicError(f"{where}: name: a topic of content {content} {rule}")
    if "bodies" in raw and not per_body:
        raise TopicError(f"{where}: bodies: {content} is one topic for all bodies; leave it out")
    frames = _FRAMES.get(content, ("",))
    frame = raw.get("frame", frames[0])
    if frame not in frames:
        allowed = " or ".join(f for f in frames if f) or "none: leave it out"
        raise TopicError(f"{where}: frame: {frame!r} for {content}; allowed: {allowed}")
    rate = float(raw.get("rate", 0.0))
    if not math.isfinite(rate):
        raise TopicError(f"{where}: rate: {rate} is not a finite number of Hz")
    if "rate" in raw and (direction == "in" or content in LATCHED):
        raise TopicError(f"{where}: rate: {content} is not sent at a rate; leave it out")
    bodies = raw.get("bodies", "*")
    if not isinstance(bodies, str):
        bodies = tuple(bodies)
    return TopicEntry(raw["name"], content, message_type, direction, frame, rate,
                      Qos(**raw.get("qos", {})), bodies, line)  # fmt: skip
