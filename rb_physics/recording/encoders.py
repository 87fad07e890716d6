"""The messages the simulator sends, encoded straight from arrays. ROS need not be installed.

Units are SI, quaternions (x, y, z, w), times ns of simulation time. Layouts are built once per
set of names; an encoder keeps its buffers, so one encoder serves one topic of one thread.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .cdr import CdrWriter, Rows, Template, split_stamp

_CLOCK = struct.Struct("<4siI")


def encode_clock(time_ns: int) -> bytes:
    """rosgraph_msgs/msg/Clock."""
    return _CLOCK.pack(b"\x00\x01\x00\x00", *split_stamp(time_ns))


def encode_string(text: str) -> bytes:
    """std_msgs/msg/String. Raises ValueError on a NUL character."""
    return CdrWriter().string(text).tobytes()


class PoseArrayEncoder:
    """geometry_msgs/msg/PoseArray of any number of poses in one frame."""

    def __init__(self, frame_id: str) -> None:
        self._frame_id = frame_id
        self._count = -1
        self._template: Template
        self._values = np.empty((0, 7))

    def encode(self, time_ns: int, positions: ArrayLike, orientations: ArrayLike) -> bytes:
        """positions (N, 3) m, orientations (N, 4)."""
        positions = np.asarray(positions)
        if len(positions) != self._count:
            self._count = len(positions)
            writer = CdrWriter().header(self._frame_id).u32(self._count)
            self._template = Template(writer.doubles("poses", 7 * self._count))
            self._values = np.empty((self._count, 7))
        if self._count == 0:
            return self._template.encode(time_ns)
        self._values[:, :3] = positions
        self._values[:, 3:] = orientations
        return self._template.encode(time_ns, {"poses": self._values})


class PoseStampedEncoder:
    """geometry_msgs/msg/PoseStamped, one message per body."""

    def __init__(self, frame_ids: Sequence[str]) -> None:
        self._rows = Rows([CdrWriter().header(frame).doubles("pose", 7) for frame in frame_ids])

    def encode(self, time_ns: int, poses: ArrayLike) -> list[bytes]:
        """poses (N, 7): position m, quaternion."""
        return self._rows.encode(time_ns, {"pose": poses})


class OdometryEncoder:
    """nav_msgs/msg/Odometry, one message per body: pose in frame_id, twist in child_frame_id.

    Covariances are zero: the simulator's state is exact.
    """

    def __init__(self, frame_ids: Sequence[str], child_frame_ids: Sequence[str]) -> None:
        self._rows = Rows(
            [
                CdrWriter()
                .header(frame)
                .string(child)
                .doubles("pose", 7)
                .f64(*([0.0] * 36))
                .doubles("twist", 6)
                .f64(*([0.0] * 36))
                for frame, child in zip(frame_ids, child_frame_ids, strict=True)
            ]
        )

    def encode(self, time_ns: int, poses: ArrayLike, twists: ArrayLike) -> list[bytes]:
        """poses (N, 7); twists (N, 6): linear m/s, angular rad/s, both in the child frame."""
        return self._rows.encode(time_ns, {"pose": poses, "twist": twists})


class WrenchStampedEncoder:
    """geometry_msgs/msg/WrenchStamped, one message per body."""

    def __init__(self, frame_ids: Sequence[str]) -> None:
        self._rows = Rows([CdrWriter().header(frame).doubles("wrench", 6) for frame in frame_ids])

    def encode(self, time_ns: int, wrenches: ArrayLike) -> list[bytes]:
        """wrenches (N, 6) or (N, 2, 3): force N, torque N m, in each message's frame."""
        wrenches = np.asarray(wrenches, np.float64)
        return self._rows.encode(time_ns, {"wrench": wrenches.reshape(len(wrenches), 6)})


class TransformEncoder:
    """tf2_msgs/msg/TFMessage with one transform per (frame_id, child_frame_id)."""

    def __init__(self, frame_ids: Sequence[str], child_frame_ids: Sequence[str]) -> None:
        writer = CdrWriter().u32(len(frame_ids))
        writer.doubles("transforms", 0)
        for frame, child in zip(frame_ids, child_frame_ids, strict=True):
            writer.header(frame).string(child).doubles("transforms", 7)
        self._template = Template(writer)

    def encode(self, time_ns: int, transforms: ArrayLike) -> bytes:
        """transforms (N, 7): translation m, quaternion."""
        return self._template.encode(time_ns, {"transforms": transforms})


POINT_FIELDS = {"u1": 2, "i4": 5, "u4": 6, "f4": 7, "f8": 8}  # numpy -> sensor_msgs/PointField


class PointCloudEncoder:
    """sensor_msgs/msg/PointCloud2 of a structured array; each field a PointField.

    Field types are uint8, int32, uint32, float32, float64 (ROS knows no 64-bit integers); a field
    with a shape, e.g. ("feature", "<u4", 2), becomes a PointField with that count.
    """

    def __init__(self, frame_id: str, dtype: np.dtype) -> None:
        self.dtype = np.dtype(dtype)
        writer = CdrWriter().header(frame_id)
        writer.u32(1, 0)
        self._width = len(writer) - 4
        if self.dtype.names is None or self.dtype.fields is None:
            raise ValueError(f"{dtype} has no fields")
        writer.u32(len(self.dtype.names))
        for name in self.dtype.names:
            field, offset = self.dtype.fields[name][:2]
            kind = field.base.str[1:]
            writer.string(name).u32(offset).u8(POINT_FIELDS[kind])
            writer.u32(int(np.prod(field.shape, dtype=int)) if field.shape else 1)
        writer.u8(0).u32(self.dtype.itemsize, 0, 0)  # little endian; point_step, row_step, size
        self._prefix = bytearray(writer.tobytes())

    def encode(self, time_ns: int, points: NDArray) -> bytes:
        """points (N,) of the encoder's dtype."""
        size = len(points) * self.dtype.itemsize
        struct.pack_into("<iI", self._prefix, 4, *split_stamp(time_ns))
        struct.pack_into("<I", self._prefix, self._width, len(points))
        struct.pack_into("<II", self._prefix, len(self._prefix) - 8, size, size)
        return b"".join((self._prefix, points.tobytes(), b"\x01"))  # is_dense: no invalid points


def encode_diagnostics(
    time_ns: int, statuses: Sequence[tuple[int, str, str, str, Mapping[str, object]]]
) -> bytes:
    """diagnostic_msgs/msg/DiagnosticArray; each status is (level 0 OK, 1 WARN, 2 ERROR, 3 STALE;
    name; message; hardware id; values)."""
    writer = CdrWriter().stamp(time_ns).string("").u32(len(statuses))
    for level, name, message, hardware_id, values in statuses:
        writer.u8(level).string(name).string(message).string(hardware_id).u32(len(values))
        for key, value in values.items():
            writer.string(key).string(f"{value:.9g}" if isinstance(value, float) else str(value))
    return writer.tobytes()


_MULTI_ARRAY_DTYPES = {
    "std_msgs/msg/Float64MultiArray": "<f8",
    "std_msgs/msg/UInt64MultiArray": "<u8",
    "std_msgs/msg/UInt8MultiArray": "u1",
}


class MultiArrayEncoder:
    """std_msgs/msg/Float64MultiArray, UInt64MultiArray or UInt8MultiArray, row major."""

    def __init__(self, labels: Sequence[str], type_name: str) -> None:
        """`labels`: one per dimension."""
        self._labels = tuple(labels)
        self._dtype = np.dtype(_MULTI_ARRAY_DTYPES[type_name])
        self._shape: tuple[int, ...] = ()
        self._prefix = b""

    def encode(self, values: ArrayLike) -> bytes:
        """values: as many dimensions as there are labels."""
        array = np.ascontiguousarray(values, self._dtype)
        if not self._prefix or array.shape != self._shape:
            if array.ndim != len(self._labels):
                raise ValueError(f"{array.ndim} dimensions for labels {self._labels}")
            writer = CdrWriter().u32(array.ndim)
            for axis, label in enumerate(self._labels):
                stride = int(np.prod(array.shape[axis:], dtype=np.int64))
                writer.string(label).u32(array.shape[axis], stride)
            writer.u32(0, array.size)
            if array.size:
                writer.align(self._dtype.itemsize)
            self._shape, self._prefix = array.shape, writer.tobytes()
        return self._prefix + array.tobytes()
