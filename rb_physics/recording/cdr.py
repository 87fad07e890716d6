"""CDR, the wire format of ROS 2 messages: a writer, fixed-layout templates over numpy, a reader.

A serialised message is a 4-byte encapsulation header (``00 01 00 00``: plain CDR, little endian)
followed by the fields in order, each aligned to its own size counted from byte 4. A string is a
u32 length that counts the closing NUL, then the bytes. A sequence is a u32 count, then the
elements; an empty sequence has no padding after its count. There is no padding at the end.

Source: OMG DDS-XTypes 1.3 section 7.4 (XCDR version 1).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

_ENCAPSULATION = b"\x00\x01\x00\x00"
_NS_PER_S = 1_000_000_000


def split_stamp(time_ns: int) -> tuple[int, int]:
    """(sec, nanosec) of a time in ns. Raises ValueError outside int32 seconds."""
    sec, nanosec = divmod(int(time_ns), _NS_PER_S)
    if not -(2**31) <= sec < 2**31:
        raise ValueError(f"time {time_ns} ns does not fit a ROS time stamp (int32 seconds)")
    return sec, nanosec


class CdrWriter:
    """Builds one message field by field, and remembers where its numbers lie.

    Fields that change later are written with a slot name: ``stamp`` and ``doubles`` note their
    offsets in `slots` (bytes from the start of the alignment, i.e. from byte 4).
    """

    def __init__(self) -> None:
        self._data = bytearray(_ENCAPSULATION)
        self.slots: dict[str, list[tuple[int, int]]] = {}  # name -> [(offset, count), ...]

    def align(self, size: int) -> CdrWriter:
        self._data.extend(b"\0" * (-(len(self._data) - 4) % size))
        return self

    def pack(self, code: str, *values: float) -> CdrWriter:
        """Writes numbers of one struct type code, aligned to its size."""
        self.align(struct.calcsize("<" + code))
        self._data.extend(struct.pack(f"<{len(values)}{code}", *values))
        return self

    def u8(self, *values: int) -> CdrWriter:
        return self.pack("B", *values)

    def i32(self, *values: int) -> CdrWriter:
        return self.pack("i", *values)

    def u32(self, *values: int) -> CdrWriter:
        return self.pack("I", *values)

    def f32(self, *values: float) -> CdrWriter:
        return self.pack("f", *values)

    def f64(self, *values: float) -> CdrWriter:
        return self.pack("d", *values)

    def string(self, text: str) -> CdrWriter:
        if "\0" in text:
            raise ValueError(f"{text!r}: a ROS string must not hold a NUL character")
        encoded = text.encode("utf-8")
        self.u32(len(encoded) + 1)
        self._data.extend(encoded + b"\0")
        return self

    def raw(self, data: bytes) -> CdrWriter:
        """Appends bytes as they are (the elements of a sequence of bytes)."""
        self._data.extend(data)
        return self

    def stamp(self, time_ns: int = 0) -> CdrWriter:
        """builtin_interfaces/Time, as one more entry of slot "stamp"."""
        self.align(4)
        self.slots.setdefault("stamp", []).append((len(self._data) - 4, 2))
        sec, nanosec = split_stamp(time_ns)
        return self.i32(sec).u32(nanosec)

    def header(self, frame_id: str) -> CdrWriter:
        """std_msgs/Header with its stamp in slot "stamp"."""
        return self.stamp().string(frame_id)

    def doubles(self, slot: str, count: int, values: Sequence[float] | None = None) -> CdrWriter:
        """`count` f64 as one more entry of `slot`; zeros unless `values` are given."""
        if count == 0:  # an empty sequence brings no padding
            self.slots.setdefault(slot, [])
            return self
        self.align(8)
        self.slots.setdefault(slot, []).append((len(self._data) - 4, count))
        return self.f64(*(values if values is not None else (0.0,) * count))

    def __len__(self) -> int:
        return len(self._data)

    def tobytes(self) -> bytes:
        return bytes(self._data)


class Template:
    """One message of fixed layout: encoded once, then only the numbers in its slots change."""

    def __init__(self, writer: CdrWriter) -> None:
        size = len(writer)
        # Byte 4 of the message, where alignment starts, lies at byte 8 of the store: f64 aligned.
        store = np.zeros((size + 4 + 7) // 8 * 8 + 8, np.uint8)
        self._message = store[4 : 4 + size]
        self._message[:] = np.frombuffer(writer.tobytes(), np.uint8)
        self._doubles = store[8:].view("<f8")
        self._words = store[8:].view("<u4")
        self._index: dict[str, NDArray[np.intp]] = {}
        self._span: dict[str, slice | None] = {}
        for name, entries in writer.slots.items():
            width = 4 if name == "stamp" else 8
            parts = [np.arange(offset // width, offset // width + n) for offset, n in entries]
            index = np.concatenate(parts) if parts else np.empty(0, np.intp)
            self._index[name] = index
            contiguous = len(index) > 0 and int(index[-1]) - int(index[0]) == len(index) - 1
            self._span[name] = slice(int(index[0]), int(index[-1]) + 1) if contiguous else None
        self._stamps = self._index.get("stamp", np.empty(0, np.intp)).reshape(-1, 2)

    def set(self, slot: str, values: ArrayLike) -> None:
        """Writes f64 values (any shape, as many as the slot holds, in its order)."""
        flat = np.asarray(values, np.float64).reshape(-1)
        span = self._span[slot]
        if span is not None:
            self._doubles[span] = flat
        elif len(flat) == len(self._index[slot]):
            self._doubles[self._index[slot]] = flat
        else:
            raise ValueError(f"slot {slot}: {len(flat)} values for {len(self._index[slot])}")

    def encode(self, time_ns: int, values: Mapping[str, ArrayLike] | None = None) -> bytes:
        """The message with every stamp at `time_ns` and the given slots filled."""
        sec, nanosec = split_stamp(time_ns)
        self._words[self._stamps] = (sec & 0xFFFFFFFF, nanosec)
        for slot, numbers in (values or {}).items():
            self.set(slot, numbers)
        return self._message.tobytes()


class Rows:
    """N messages of one type whose strings differ, filled and encoded in one vectorised go.

    Messages of equal layout share one (rows, bytes) array, so the cost is a few array operations
    for each distinct layout (at most a handful: names only shift the doubles by multiples of 8).
    """

    def __init__(self, writers: Sequence[CdrWriter]) -> None:
        self._count = len(writers)
        layouts: dict[tuple, list[int]] = {}
        for row, writer in enumerate(writers):
            slots = tuple((name, *entries) for name, entries in sorted(writer.slots.items()))
            layouts.setdefault((len(writer), slots), []).append(row)
        self._groups = []
        for (size, slots), rows in layouts.items():
            stride = (size + 4 + 7) // 8 * 8 + 8
            store = np.zeros((len(rows), stride), np.uint8)
            for i, row in enumerate(rows):
                store[i, 4 : 4 + size] = np.frombuffer(writers[row].tobytes(), np.uint8)
            words, doubles = store.view("<u4"), store.view("<f8")
            views: dict[str, NDArray] = {}
            for name, (offset, count) in slots:  # one entry a slot: a row has no repeated parts
                width, source = (4, words) if name == "stamp" else (8, doubles)
                first = (offset + 8) // width
                views[name] = source[:, first : first + count]
            self._groups.append((np.array(rows), store, size, views))

    def encode(self, time_ns: int, values: Mapping[str, ArrayLike]) -> list[bytes]:
        """One bytes object per row; `values` maps a slot to an (N, count) array."""
        sec, nanosec = split_stamp(time_ns)
        arrays = {slot: np.asarray(numbers, np.float64) for slot, numbers in values.items()}
        for slot, numbers in arrays.items():
            if len(numbers) != self._count:
                raise ValueError(f"slot {slot}: {len(numbers)} rows for {self._count} messages")
        out: list[bytes] = [b""] * self._count
        for rows, store, size, views in self._groups:
            views["stamp"][:] = (sec & 0xFFFFFFFF, nanosec)
            for slot, numbers in arrays.items():
                views[slot][:] = numbers[rows]
            blob, stride = store.tobytes(), store.shape[1]
            for i, row in enumerate(rows.tolist()):
                start = i * stride + 4
                out[row] = blob[start : start + size]
        return out


class CdrReader:
    """Reads a serialised message field by field, in either byte order; strict about its length.

    Every method raises ValueError when the bytes don't hold what it should read.
    """

    def __init__(self, data: bytes) -> None:
        if len(data) < 4:
            raise ValueError(f"a serialised message has at least 4 bytes, got {len(data)}")
        if data[0] != 0 or data[1] not in (0, 1):
            raise ValueError(
                f"encapsulation {bytes(data[:2]).hex()} is not plain CDR (0000 or 0001)"
            )
        self.order: Literal["<", ">"] = "<" if data[1] == 1 else ">"
        self._data = data
        self._position = 4

    @property
    def position(self) -> int:
        """Bytes read, the encapsulation header included."""
        return self._position

    def _take(self, size: int, align: int, what: str) -> int:
        start = self._position + (-(self._position - 4) % align)
        if start + size > len(self._data):
            raise ValueError(
                f"message ends at byte {len(self._data)}, but {what} needs {start + size} bytes"
            )
        self._position = start + size
        return start

    def unpack(self, code: str, count: int = 1) -> tuple:
        size = struct.calcsize("<" + code)
        start = self._take(size * count, size, f"{count} number(s)")
        return struct.unpack_from(f"{self.order}{count}{code}", self._data, start)

    def u8(self) -> int:
        return int(self.unpack("B")[0])

    def i32(self) -> int:
        return int(self.unpack("i")[0])

    def u32(self) -> int:
        return int(self.unpack("I")[0])

    def seek(self, position: int) -> None:
        """Go on reading at `position`."""
        self._position = position

    def count(self, size: int) -> int:
        """The length of a sequence whose elements take at least `size` bytes each."""
        count = self.u32()
        if count * size > len(self._data) - self._position:
            raise ValueError(f"a sequence of {count} elements does not fit into the message")
        return count

    def string(self) -> str:
        length = self.u32()
        if length == 0:  # some vendors write the empty string without its NUL
            return ""
        start = self._take(length, 1, f"a string of {length} bytes")
        raw = bytes(self._data[start : start + length])
        if raw[-1] != 0 or 0 in raw[:-1]:
            raise ValueError("a string does not end in its one NUL")
        try:
            return raw[:-1].decode("utf-8")
        except UnicodeDecodeError as error:
            raise ValueError(f"a string is not UTF-8: {error.reason}") from None

    def stamp(self) -> int:
        """builtin_interfaces/Time in ns."""
        return self.i32() * _NS_PER_S + self.u32()

    def array(self, dtype: str, count: int) -> NDArray:
        """`count` numbers as a read-only array over the message's own bytes."""
        if count == 0:
            return np.empty(0, dtype)
        element = np.dtype(dtype).newbyteorder(self.order)
        start = self._take(element.itemsize * count, min(element.alignment, 8), f"{count} numbers")
        return np.frombuffer(self._data, element, count, start)

    def raw(self, count: int) -> memoryview:
        start = self._take(count, 1, f"{count} bytes")
        return memoryview(self._data)[start : start + count]

    def end(self) -> None:
        """Raises ValueError when bytes are left over (up to 3 of padding are legal)."""
        left = len(self._data) - self._position
        if left > 3:
            raise ValueError(f"{left} bytes are left over after the last field")
