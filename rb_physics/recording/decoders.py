"""Messages decoded from their bytes: the inputs of the node, and what a log is read back with."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cdr import CdrReader


class Stamped(NamedTuple):
    """A stamped message of doubles, in the frame `frame_id`."""

    time_ns: int  # header.stamp
    frame_id: str
    values: tuple[float, ...]

    @property
    def finite(self) -> bool:
        """False when any number is NaN or infinite."""
        return all(map(math.isfinite, self.values))


_LITTLE = b"\0\1\0\0"  # encapsulation of plain little-endian CDR
_STAMP_AND_LENGTH = struct.Struct("<iII")
_DOUBLES = {count: struct.Struct(f"<{count}d") for count in (6, 7)}


def _decode_stamped(data: bytes, count: int, type_name: str) -> Stamped:
    values = _DOUBLES[count]
    try:
        if data[:4] == _LITTLE and len(data) > 16:  # the usual, and the quick way
            sec, nanosec, length = _STAMP_AND_LENGTH.unpack_from(data, 4)
            start = 16 + length + (4 - length) % 8  # the doubles are aligned to 8 from byte 4
            name = data[16 : 16 + length]
            plain = name.isascii() and name.find(b"\0") == length - 1
            if plain and start + values.size == len(data):
                frame_id = str(name[:-1], "ascii")
                return Stamped(sec * 10**9 + nanosec, frame_id, values.unpack_from(data, start))
        reader = CdrReader(data)
        stamped = Stamped(reader.stamp(), reader.string(), reader.unpack("d", count))
        reader.end()
    except ValueError as error:
        raise ValueError(f"malformed {type_name}: {error}") from None
    return stamped


def decode_wrench_stamped(data: bytes) -> Stamped:
    """values: force (3) N, torque (3) N m. Raises ValueError on malformed bytes."""
    return _decode_stamped(data, 6, "geometry_msgs/msg/WrenchStamped")


def decode_pose_stamped(data: bytes) -> Stamped:
    """values: position (3) m, quaternion x y z w. Raises ValueError on malformed bytes."""
    return _decode_stamped(data, 7, "geometry_msgs/msg/PoseStamped")


def decode_twist_stamped(data: bytes) -> Stamped:
    """values: linear (3) m/s, angular (3) rad/s. Raises ValueError on malformed bytes."""
    return _decode_stamped(data, 6, "geometry_msgs/msg/TwistStamped")


class MultiDofJoints(NamedTuple):
    """sensor_msgs/msg/MultiDOFJointState: what is known of many bodies at once."""

    time_ns: int  # header.stamp
    frame_id: str
    names: tuple[str, ...]
    transforms: NDArray  # (N or 0, 7) position m, quaternion
    twists: NDArray  # (N or 0, 6) m/s, rad/s
    wrenches: NDArray  # (N or 0, 6) N, N m


class MultiDofJointsDecoder:
    """Decodes messages of one topic; names that are those of the last message are not read again."""

    def __init__(self) -> None:
        self._prefix = b"\0"  # encapsulation and what lies between stamp and numbers
        self._frame_id = ""
        self._names: tuple[str, ...] = ()

    def decode(self, data: bytes) -> MultiDofJoints:
        """`names` is the same object as before when nothing in it has changed. Raises ValueError on
        malformed bytes."""
        try:
            reader = CdrReader(data)
            time_ns = reader.stamp()
            end = 8 + len(self._prefix)
            if data[:4] + data[12:end] == self._prefix:
                reader.seek(end)
            else:
                self._frame_id = reader.string()
                self._names = tuple(reader.string() for _ in range(reader.count(4)))
                self._prefix = bytes(data[:4] + data[12 : reader.position])
            rows = []
            for width in (7, 6, 6):
                count = reader.count(8 * width)
                rows.append(np.array(reader.array("f8", count * width), "f8").reshape(count, width))
            reader.end()
        except ValueError as error:
            self._prefix = b"\0"
            raise ValueError(f"malformed sensor_msgs/msg/MultiDOFJointState: {error}") from None
        return MultiDofJoints(time_ns, self._frame_id, self._names, *rows)


def stack_doubles(
    messages: Sequence[bytes], decode: Callable[[bytes], NDArray], stamped: bool
) -> NDArray:
    """(M, N): the N f64 that `decode` finds at the end of each message.

    Messages that differ only in those, and in their stamp if `stamped`, are taken at once.
    """
    first = decode(messages[0])
    size, tail = len(messages[0]), 8 * len(first)
    if messages[0][:4] == _LITTLE and all(len(message) == size for message in messages):
        table = np.frombuffer(b"".join(messages), np.uint8).reshape(-1, size)
        begin = 12 if stamped else 4
        alike = np.array_equal(table[:, :4], np.broadcast_to(table[0, :4], (len(table), 4)))
        fixed = table[:, begin : size - tail]
        values = np.ascontiguousarray(table[:, size - tail :]).view("<f8")
        # The first one shows that the numbers are at the end, not followed by padding.
        if alike and np.all(fixed == fixed[0]) and values[0].tobytes() == first.tobytes():
            return values
    return np.stack([decode(message) for message in messages])


def decode_clock(data: bytes) -> int:
    """rosgraph_msgs/msg/Clock: time in ns."""
    return CdrReader(data).stamp()


def decode_string(data: bytes) -> str:
    """std_msgs/msg/String."""
    return CdrReader(data).string()


def decode_pose_array(data: bytes) -> tuple[int, str, NDArray]:
    """(stamp in ns, frame, poses (N, 7))."""
    reader = CdrReader(data)
    time_ns, frame_id, count = reader.stamp(), reader.string(), reader.u32()
    poses = reader.array("f8", 7 * count).reshape(count, 7)
    reader.end()
    return time_ns, frame_id, poses


def decode_odometry(data: bytes) -> tuple[str, NDArray, NDArray]:
    """nav_msgs/msg/Odometry: (child frame, pose (7,), twist (6,) m/s and rad/s in the child frame)."""
    reader = CdrReader(data)
    reader.stamp(), reader.string()
    child = reader.string()
    pose = reader.array("f8", 7 + 36)[:7]
    twist = reader.array("f8", 6 + 36)[:6]
    reader.end()
    return child, pose, twist


def decode_transforms(data: bytes) -> list[tuple[int, str, str, tuple[float, ...]]]:
    """tf2_msgs/msg/TFMessage: a list of (stamp in ns, frame, child frame, 7 doubles).
    Raises ValueError on malformed bytes."""
    try:
        reader = CdrReader(data)
        transforms = [
            (reader.stamp(), reader.string(), reader.string(), reader.unpack("d", 7))
            for _ in range(reader.count(64))
        ]
        reader.end()
    except ValueError as error:
        raise ValueError(f"malformed tf2_msgs/msg/TFMessage: {error}") from None
    return transforms


_POINT_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def decode_point_cloud(data: bytes) -> tuple[int, str, NDArray]:
    """sensor_msgs/msg/PointCloud2: (stamp in ns, frame, structured array (N,))."""
    return PointCloudDecoder()(data)


class PointCloudDecoder:
    """`decode_point_cloud` of many messages of one topic, whose description of the point is the
    same each time: it is read once.
    """

    def __init__(self) -> None:
        self._frame: tuple[bytes, int] = (b"\0", 12)  # of the last message: bytes, offset behind
        self._fields: tuple[bytes, int, np.dtype] | None = None  # bytes, offset behind, point

    def __call__(self, data: bytes) -> tuple[int, str, NDArray]:
        """Raises ValueError on malformed bytes."""
        frame, start = self._frame
        if self._fields is not None and data[:4] == _LITTLE and data[12:start] == frame:
            fields, end, point = self._fields
            if data[start + 8 : end] == fields and len(data) >= end + 8:
                sec, nanosec = struct.unpack_from("<iI", data, 4)
                height, width = struct.unpack_from("<II", data, start)
                _, size = struct.unpack_from("<II", data, end)
                count = height * width
                if size == count * point.itemsize and end + 9 + size == len(data):
                    points = np.frombuffer(data, point, count, end + 8)
                    return sec * 1_000_000_000 + nanosec, self._name, points
        return self._read(data)

    def _read(self, data: bytes) -> tuple[int, str, NDArray]:
        reader = CdrReader(data)
        time_ns, frame_id, height = reader.stamp(), reader.string(), reader.u32()
        start = reader.position - 4
        width = reader.u32()
        names, formats, offsets = [], [], []
        for _ in range(reader.u32()):
            names.append(reader.string())
            offsets.append(reader.u32())
            kind, count = reader.u8(), reader.u32()
            if kind not in _POINT_TYPES:
                raise ValueError(f"point field {names[-1]} has unknown type {kind}")
            formats.append(_POINT_TYPES[kind] if count == 1 else (_POINT_TYPES[kind], count))
        order: Literal["<", ">"] = ">" if reader.u8() else "<"
        point_step = reader.u32()
        end = reader.position
        reader.u32()  # row_step
        size = reader.u32()
        if size != height * width * point_step:
            raise ValueError(f"{size} bytes for {height} x {width} points of {point_step} bytes")
        dtype = np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": point_step}
        ).newbyteorder(order)
        if reader.order == "<" and dtype.itemsize > 0:
            self._name, self._frame = frame_id, (bytes(data[12:start]), start)
            self._fields = (bytes(data[start + 8 : end]), end, dtype)
        points = np.frombuffer(reader.raw(size), dtype) if size else np.empty(0, dtype)
        reader.u8()  # is_dense
        reader.end()
        return time_ns, frame_id, points


def decode_multi_array(data: bytes, dtype: str) -> tuple[tuple[str, ...], NDArray]:
    """std_msgs/msg/*MultiArray of element type `dtype`: (labels, array in the message's shape)."""
    reader = CdrReader(data)
    dimensions = [(reader.string(), reader.u32(), reader.u32()) for _ in range(reader.u32())]
    reader.u32()  # data_offset
    values = reader.array(dtype, reader.u32())
    reader.end()
    shape = tuple(size for _, size, _ in dimensions)
    if int(np.prod(shape, dtype=np.int64)) != len(values):
        raise ValueError(f"{len(values)} values for shape {shape}")
    return tuple(label for label, _, _ in dimensions), values.reshape(shape)


def decode_json_list(data: bytes) -> list[str]:
    """std_msgs/msg/String that holds a JSON list of texts. Raises ValueError."""
    content = json.loads(decode_string(data))
    if not isinstance(content, list) or not all(isinstance(item, str) for item in content):
        raise ValueError("not a JSON list of texts")
    return content
