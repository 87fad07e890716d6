"""Every encoder against rclpy's own deserialiser, every decoder against its serialiser."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rb_physics.recording import decoders, encoders

serialization = pytest.importorskip("rclpy.serialization")
from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from geometry_msgs.msg import (  # noqa: E402
    PoseArray,
    PoseStamped,
    TwistStamped,
    WrenchStamped,
)
from nav_msgs.msg import Odometry  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import PointCloud2  # noqa: E402
from std_msgs.msg import (  # noqa: E402
    Float64MultiArray,
    String,
    UInt8MultiArray,
    UInt64MultiArray,
)

FINITE = st.floats(allow_nan=False, allow_infinity=False)
TIMES = st.integers(0, (2**31 - 1) * 10**9 + 999_999_999)
FRAMES = st.text(st.characters(min_codepoint=1, codec="utf-8"), max_size=12)
TIME = 1_234_567_890_123


def decode(data: bytes, message_type: type):
    return serialization.deserialize_message(data, message_type)


def stamp_ns(header) -> int:
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def pose_numbers(pose) -> list[float]:
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def vector_numbers(*vectors) -> list[float]:
    return [x for v in vectors for x in (v.x, v.y, v.z)]


def random_poses(count: int) -> np.ndarray:
    return np.random.default_rng(count).normal(size=(count, 7))


@given(TIMES)
def test_clock(time_ns):
    clock = decode(encoders.encode_clock(time_ns), Clock).clock
    assert clock.sec * 10**9 + clock.nanosec == time_ns
    assert decoders.decode_clock(encoders.encode_clock(time_ns)) == time_ns


def test_time_outside_int32_seconds_is_refused():
    with pytest.raises(ValueError, match="does not fit a ROS time stamp"):
        encoders.encode_clock(2**31 * 10**9)


@given(FRAMES)
def test_string(text):
    assert decode(encoders.encode_string(text), String).data == text
    assert decoders.decode_string(encoders.encode_string(text)) == text


def test_string_with_nul_is_refused():
    with pytest.raises(ValueError, match="NUL"):
        encoders.encode_string("a\0b")


@pytest.mark.parametrize("count", [0, 1, 2, 7, 100, 1000])
@pytest.mark.parametrize("frame", ["", "w", "world", "worlds", "a_frame/with/parts"])
def test_pose_array(count, frame):
    poses = random_poses(count)
    encoder = encoders.PoseArrayEncoder(frame)
    encoder.encode(0, np.ones((3, 3)), np.ones((3, 4)))  # a count before, so that it must rebuild
    data = encoder.encode(TIME, poses[:, :3], poses[:, 3:])
    message = decode(data, PoseArray)
    assert (stamp_ns(message.header), message.header.frame_id) == (TIME, frame)
    assert [pose_numbers(p) for p in message.poses] == poses.tolist()
    again = decoders.decode_pose_array(data)
    assert again[:2] == (TIME, frame)
    assert np.array_equal(again[2], poses)


@settings(max_examples=40)
@given(TIMES, st.lists(st.tuples(FRAMES, st.lists(FINITE, min_size=6, max_size=6)), max_size=12))
def test_wrench_rows(time_ns, rows):
    encoder = encoders.WrenchStampedEncoder([frame for frame, _ in rows])
    encoder.encode(1, np.ones((len(rows), 6)))
    encoded = encoder.encode(time_ns, np.array([w for _, w in rows]).reshape(-1, 2, 3))
    assert len(encoded) == len(rows)
    for data, (frame, wrench) in zip(encoded, rows, strict=True):
        message = decode(data, WrenchStamped)
        assert (stamp_ns(message.header), message.header.frame_id) == (time_ns, frame)
        assert vector_numbers(message.wrench.force, message.wrench.torque) == wrench
        assert decoders.decode_wrench_stamped(data) == (time_ns, frame, tuple(wrench))


@pytest.mark.parametrize("count", [0, 1, 3, 1000])
def test_pose_stamped_and_odometry_rows(count):
    poses, twists = random_poses(count), random_poses(count)[:, :6] - 1
    names = [f"b{'x' * (i % 9)}{i}" for i in range(count)]
    encoded = encoders.PoseStampedEncoder(names).encode(TIME, poses)
    for data, name, pose in zip(encoded, names, poses.tolist(), strict=True):
        message = decode(data, PoseStamped)
        assert (message.header.frame_id, pose_numbers(message.pose)) == (name, pose)
    encoder = encoders.OdometryEncoder(["world"] * count, names)
    for data, name, pose, twist in zip(
        encoder.encode(TIME, poses, twists), names, poses.tolist(), twists.tolist(), strict=True
    ):
        message = decode(data, Odometry)
        assert (message.header.frame_id, message.child_frame_id) == ("world", name)
        assert pose_numbers(message.pose.pose) == pose
        twist_message = message.twist.twist
        assert vector_numbers(twist_message.linear, twist_message.angular) == twist
        assert not message.pose.covariance.any()
        assert not message.twist.covariance.any()


@pytest.mark.parametrize("count", [0, 1, 2, 17])
def test_transforms(count):
    # tf2_msgs is not among the ROS wheels, so the independent reader is rosbags' here.
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    transforms = random_poses(count)
    children = [f"body_{'y' * i}" for i in range(count)]
    data = encoders.TransformEncoder(["world"] * count, children).encode(TIME, transforms)
    message = store.deserialize_cdr(data, "tf2_msgs/msg/TFMessage")
    assert [t.child_frame_id for t in message.transforms] == children
    for t, numbers in zip(message.transforms, transforms.tolist(), strict=True):
        assert (stamp_ns(t.header), t.header.frame_id) == (TIME, "world")
        q = t.transform.rotation
        assert [*vector_numbers(t.transform.translation), q.x, q.y, q.z, q.w] == numbers
    assert decoders.decode_transforms(data) == [
        (TIME, "world", child, tuple(t))
        for child, t in zip(children, transforms.tolist(), strict=True)
    ]


POINT = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("f", "<f8"), ("id", "<i4"), ("key", "<u4", 2),
     ("kind", "u1")]
)  # fmt: skip


@pytest.mark.parametrize("count", [0, 1, 5, 1000])
@pytest.mark.parametrize("frame", ["world", "abc"])
def test_point_cloud(count, frame):
    points = np.zeros(count, POINT)
    points["x"], points["f"], points["key"][:, 1] = np.arange(count), -1.5, np.arange(count)
    encoder = encoders.PointCloudEncoder(frame, POINT)
    encoder.encode(1, np.zeros(3, POINT))
    data = encoder.encode(TIME, points)
    message = decode(data, PointCloud2)
    assert (stamp_ns(message.header), message.header.frame_id) == (TIME, frame)
    assert (message.height, message.width, message.point_step) == (1, count, POINT.itemsize)
    assert message.row_step == count * POINT.itemsize
    assert not message.is_bigendian
    assert message.is_dense
    assert [(f.name, f.offset, f.datatype, f.count) for f in message.fields] == [
        ("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1), ("f", 12, 8, 1), ("id", 20, 5, 1),
        ("key", 24, 6, 2), ("kind", 32, 2, 1),
    ]  # fmt: skip
    assert bytes(message.data) == points.tobytes()
    again = decoders.decode_point_cloud(data)[2]
    assert np.array_equal(again["key"], points["key"])
    assert np.array_equal(again["f"], points["f"])


def test_diagnostics():
    statuses = [
        (0, "solver", "ok", "", {"residual": 1.5e-13, "contacts": 7}),
        (2, "log", "disk full: ä", "id", {}),
    ]
    message = decode(encoders.encode_diagnostics(TIME, statuses), DiagnosticArray)
    assert stamp_ns(message.header) == TIME
    assert [(s.level, s.name, s.message, s.hardware_id) for s in message.status] == [
        (b"\x00", "solver", "ok", ""),
        (b"\x02", "log", "disk full: ä", "id"),
    ]
    values = [(v.key, v.value) for v in message.status[0].values]
    assert values == [("residual", "1.5e-13"), ("contacts", "7")]
    assert decode(encoders.encode_diagnostics(0, []), DiagnosticArray).status == []


@pytest.mark.parametrize(
    ("type_name", "message_type", "dtype"),
    [
        ("std_msgs/msg/Float64MultiArray", Float64MultiArray, "f8"),
        ("std_msgs/msg/UInt64MultiArray", UInt64MultiArray, "u8"),
        ("std_msgs/msg/UInt8MultiArray", UInt8MultiArray, "u1"),
    ],
)
@pytest.mark.parametrize("shape", [(0, 2), (1, 2), (5, 3), (9, 1)])
def test_multi_array(type_name, message_type, dtype, shape):
    values = np.arange(np.prod(shape), dtype=dtype).reshape(shape)
    data = encoders.MultiArrayEncoder(("row", "columns"), type_name).encode(values)
    message = decode(data, message_type)
    assert [d.label for d in message.layout.dim] == ["row", "columns"]
    assert [d.size for d in message.layout.dim] == list(shape)
    assert [d.stride for d in message.layout.dim] == [shape[0] * shape[1], shape[1]]
    assert list(message.data) == values.reshape(-1).tolist()
    labels, again = decoders.decode_multi_array(data, dtype)
    assert labels == ("row", "columns")
    assert np.array_equal(again, values)


@settings(max_examples=60)
@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999), FRAMES,
       st.lists(FINITE, min_size=7, max_size=7))  # fmt: skip
def test_decoders_read_what_rclpy_writes(sec, nanosec, frame, numbers):
    wrench, twist, pose = WrenchStamped(), TwistStamped(), PoseStamped()
    for message in (wrench, twist, pose):
        message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
        message.header.frame_id = frame
    for first, second in ((wrench.wrench.force, wrench.wrench.torque),
                          (twist.twist.linear, twist.twist.angular)):  # fmt: skip
        first.x, first.y, first.z, second.x, second.y, second.z = numbers[:6]
    p, q = pose.pose.position, pose.pose.orientation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = numbers
    time_ns = sec * 10**9 + nanosec
    for message, decoder, count in (
        (wrench, decoders.decode_wrench_stamped, 6),
        (twist, decoders.decode_twist_stamped, 6),
        (pose, decoders.decode_pose_stamped, 7),
    ):
        data = serialization.serialize_message(message)
        assert decoder(data) == (time_ns, frame, tuple(numbers[:count]))


def wrench_bytes(order: str, frame: bytes = b"box/com\0", numbers=(1.0, 2, 3, 4, 5, 6)) -> bytes:
    body = struct.pack(f"{order}iII", 3, 4, len(frame)) + frame
    body += b"\0" * (-len(body) % 8)
    return (
        (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + body + struct.pack(f"{order}6d", *numbers)
    )


def test_both_byte_orders():
    expected = (3_000_000_004, "box/com", (1.0, 2, 3, 4, 5, 6))
    assert decoders.decode_wrench_stamped(wrench_bytes("<")) == expected
    assert decoders.decode_wrench_stamped(wrench_bytes(">")) == expected


def test_nan_is_seen():
    assert decoders.decode_wrench_stamped(wrench_bytes("<")).finite
    for bad in (math.nan, math.inf, -math.inf):
        assert not decoders.decode_wrench_stamped(
            wrench_bytes("<", numbers=(0, 0, bad, 0, 0, 0))
        ).finite


def test_every_truncation_is_refused():
    whole = wrench_bytes("<")
    for length in range(len(whole)):
        with pytest.raises(ValueError, match="WrenchStamped"):
            decoders.decode_wrench_stamped(whole[:length])


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (wrench_bytes("<") + b"\0" * 4, "left over"),
        (b"\0\x0b\0\0" + wrench_bytes("<")[4:], "encapsulation"),
        (wrench_bytes("<", frame=b"box/comx"), "NUL"),
        (wrench_bytes("<", frame=b"a\0b\0"), "NUL"),
        (wrench_bytes("<", frame=b"\xff\xfe\xfd\0"), "UTF-8"),
        (wrench_bytes("<")[:12] + b"\xff\xff\xff\xff" + wrench_bytes("<")[16:], "needs"),
    ],
)
def test_malformed_bytes_are_refused(data, reason):
    with pytest.raises(ValueError, match=reason):
        decoders.decode_wrench_stamped(data)


@settings(max_examples=200)
@given(st.binary(max_size=200))
def test_any_bytes_decode_or_raise_value_error(noise):
    for data in (noise, b"\0\1\0\0" + noise, b"\0\0\0\0" + noise):
        for decoder in (decoders.decode_wrench_stamped, decoders.decode_pose_array,
                        decoders.decode_transforms, decoders.decode_string):  # fmt: skip
            try:
                decoder(data)
            except ValueError:
                continue
