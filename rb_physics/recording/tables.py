"""A recording as tables: one numpy structured array for poses, wrenches, contacts, totals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .log_reader import Recording, damage_told
from .outputs import CONTACT_POINT, TOTALS
from .topics import SENSORS

POSE = np.dtype([("time", "f8"), ("body", "i4"), ("position", "f8", 3), ("orientation", "f8", 4)])
WRENCH = np.dtype(
    [("time", "f8"), ("body", "i4"), ("topic", "i4"), ("force", "f8", 3), ("torque", "f8", 3)]
)
CONTACT = np.dtype([("time", "f8"), *CONTACT_POINT.descr])
TOTAL = np.dtype([(name, "f8") for name in TOTALS])


class Tables(NamedTuple):
    """Columns of a recording. `time` is log time in s; `body` indexes `bodies`."""

    bodies: list[str]  # every name that occurred, in the order of appearance
    poses: NDArray  # POSE, world frame
    wrenches: NDArray  # WRENCH, contact wrenches as published; `topic` indexes `topics`
    contacts: NDArray  # CONTACT; body_a, body_b index `bodies`
    totals: NDArray  # TOTAL
    topics: list[str]  # of wrenches
    frames: list[str]  # of each of those topics


def read_tables(recording: str | Path) -> Tables:
    """Reads all of a recording made by rb_physics. Raises RecordingError."""
    log = Recording(recording)
    topics = log.attachment("topics.json", "was not made by rb_physics: it has no topics.json")
    with damage_told(log):
        contents = {t["name"]: (t["content"], t["body"]) for t in json.loads(topics)}
        return _read(log, contents)


def _read(log: Recording, contents: dict[str, tuple[str, str | None]]) -> Tables:
    index: dict[str, int] = {}
    topics: dict[str, int] = {}
    frames: list[str] = []
    rows: NDArray = np.empty(0, np.int32)  # of the present rows of the world: index in `bodies`
    poses: list[NDArray] = []
    wrenches: list[tuple] = []
    contacts: list[NDArray] = []
    totals: list[tuple] = []
    for message in log.messages():
        content, body = contents.get(message.topic) or _content_of_later_topic(message.topic)
        time = message.log_time / 1e9
        if content == "body_names":
            names = decoders.decode_json_list(message.data)
            rows = np.array([index.setdefault(name, len(index)) for name in names], np.int32)
        elif content == "poses":
            values = decoders.decode_pose_array(message.data)[2]
            table = np.empty(len(values), POSE)
            table["time"], table["body"] = time, rows
            table["position"], table["orientation"] = values[:, :3], values[:, 3:]
            poses.append(table)
        elif content in SENSORS and body is not None:
            wrench = decoders.decode_wrench_stamped(message.data)
            body_row = index.setdefault(body, len(index))
            topic = topics.setdefault(message.topic, len(topics))
            if topic == len(frames):
                frames.append(wrench.frame_id)
            wrenches.append((time, body_row, topic, wrench.values[:3], wrench.values[3:]))
        elif content == "contacts":
            points = decoders.decode_point_cloud(message.data)[2]
            table = np.empty(len(points), CONTACT)
            table["time"] = time
            for name in points.dtype.names or ():
                table[name] = points[name]
            for name in ("body_a", "body_b"):
                table[name] = rows[points[name]]
            contacts.append(table)
        elif content == "totals":
            totals.append(tuple(decoders.decode_multi_array(message.data, "f8")[1]))
    return Tables(
        list(index),
        np.concatenate(poses) if poses else np.empty(0, POSE),
        np.array(wrenches, WRENCH),
        np.concatenate(contacts) if contacts else np.empty(0, CONTACT),
        np.array(totals, TOTAL),
        list(topics),
        frames,
    )


def _content_of_later_topic(name: str) -> tuple[str, str | None]:
    """Contact wrenches of bodies that were added during the run aren't in topics.json."""
    parts = name.split("/")
    for at in (-3, -4):  # .../bodies/NAME/contact_wrench, and a pair's with OTHER behind it
        if len(parts) > -at and parts[at] == "bodies" and parts[at + 2] == "contact_wrench":
            return "contact_wrench", parts[at + 1]
    return "", None
