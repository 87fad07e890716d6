"""How the bodies of a recording moved, ready to be set against those of another one."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .log_reader import Recording, damage_told
from .operations import MOVE_BODIES
from .operations import from_json as operation_from_json
from .quaternions import rotate

# What was logged at one time may be several states: a node shows the world before and after a
# reset. `jumps` tells them apart: operations of that time that moved bodies, made before the sample.
_MOMENT = [("time", "i8"), ("jumps", "i8")]
POSE = np.dtype([*_MOMENT, ("body", "i4"), ("values", "f8", 7)])
VELOCITY = np.dtype([*_MOMENT, ("body", "i4"), ("values", "f8", 6)])


class Motions(NamedTuple):
    """Samples of all bodies, in the order of the log. `time` is log time in ns."""

    bodies: list[str]  # every name that occurred; `body` indexes them
    poses: NDArray  # POSE: position m, quaternion; world frame
    velocities: NDArray  # VELOCITY, of bodies with odometry: m/s, rad/s of their origin, world axes
    dt: float  # s, one step; 0 where it is not noted
    hash_version: str  # hashes of different ones can't be compared
    hashes: NDArray  # (N, 2): step since log time 0, state hash


def read_motions(recording: str | Path) -> Motions:
    """Reads all of a recording made by rb_physics. Raises RecordingError."""
    log = Recording(recording)
    topics = log.attachment("topics.json", "was not made by rb_physics: it has no topics.json")
    with damage_told(log):
        contents = {topic["name"]: topic["content"] for topic in json.loads(topics)}
        return _read(log, contents, log.custom_data)


def _read(log: Recording, contents: dict[str, str], notes: dict[str, str]) -> Motions:
    namespace = "/" + notes.get("node_name", "").strip("/") + "/"
    contents |= {namespace + name: name for name in ("operations", "state_hash")}
    index: dict[str, int] = {}
    rows: NDArray = np.empty(0, np.int32)  # of the present rows of the world: index in `bodies`
    poses, velocities = [np.empty(0, POSE)], [np.empty(0, VELOCITY)]
    hashes = [np.empty((0, 2), np.uint64)]
    moved_at, jumps = -1, 0  # log time of the last operations that moved bodies; how many they are
    begun = False  # what is done before the first output makes the state the recording begins with

    def samples(dtype: np.dtype, time: int, bodies: NDArray, values: NDArray) -> NDArray:
        nonlocal begun
        begun = True
        table = np.empty(len(values), dtype)
        table["time"], table["jumps"] = time, jumps if time == moved_at else 0
        table["body"], table["values"] = bodies, values
        return table

    for message in log.messages():
        content = contents.get(message.topic)
        if content == "body_names":
            names = decoders.decode_json_list(message.data)
            rows = np.array([index.setdefault(name, len(index)) for name in names], np.int32)
        elif content == "poses":
            values = decoders.decode_pose_array(message.data)[2]
            poses.append(samples(POSE, message.log_time, rows, values))
        elif message.type == "nav_msgs/msg/Odometry":  # those of bodies added later, too
            body, pose, twist = decoders.decode_odometry(message.data)
            row = np.array([index.setdefault(body, len(index))], np.int32)
            turned = rotate(np.array([pose[3:]] * 2), twist.reshape(2, 3)).reshape(1, 6)
            velocities.append(samples(VELOCITY, message.log_time, row, turned))
        elif content == "operations":
            operation = operation_from_json(decoders.decode_string(message.data))
            if begun and operation.name in MOVE_BODIES:
                jumps = jumps + 1 if moved_at == message.log_time else 1
                moved_at = message.log_time
        elif content == "state_hash":
            hashes.append(decoders.decode_multi_array(message.data, "u8")[1].reshape(-1, 2))
    table = np.concatenate(hashes)
    table[:, 0] += np.uint64(int(notes.get("first_step", "0")))
    return Motions(
        list(index), np.concatenate(poses), np.concatenate(velocities),
        float(notes.get("dt", "0")), notes.get("format_version", ""), table,
    )  # fmt: skip
