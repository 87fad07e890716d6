"""Writing one MCAP file: messages gathered into compressed chunks, and an index behind them.

The mcap package's own `Writer` spends most of a recorder's time on an object and several calls a
message, and keeps an object per chunk and channel until the end of the file. Here a message is one
`struct.pack`, and the index waits as bytes; the rarer records are still the package's.

Source: MCAP format specification, https://mcap.dev/spec
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping
from typing import Any, Protocol

COMPRESSIONS = ("zstd", "lz4", "none")
_MAGIC = b"\x89MCAP0\r\n"
_MESSAGE, _CHUNK, _MESSAGE_INDEX, _CHUNK_INDEX = 0x05, 0x06, 0x07, 0x08
_MESSAGE_HEAD = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log and publish time
_MESSAGE_FIELDS = _MESSAGE_HEAD.size - 9  # bytes of them that the length counts
_CHUNK_HEAD = struct.Struct("<BQQQQI")  # opcode, length, first and last time, size, CRC-32
_INDEX_HEAD = struct.Struct("<BQHI")  # opcode, length, channel, bytes of entries
_CHUNK_INDEX_HEAD = struct.Struct("<BQQQQQI")  # … first and last time, offset, length, bytes
_OFFSET = struct.Struct("<HQ")  # channel, offset of its message index


class Output(Protocol):
    """Where the bytes go; `tell` counts all of them."""

    def write(self, data: bytes) -> int: ...
    def tell(self) -> int: ...


class McapWriter:
    """One file: `start`, then anything in any order, then `finish`."""

    def __init__(
        self, output: Output, compression: str = "zstd", chunk_bytes: int = 1 << 18
    ) -> None:
        """`chunk_bytes`: a chunk is completed when its messages exceed so much, uncompressed."""
        self._out, self._chunk_bytes = output, chunk_bytes
        self._compression = "" if compression == "none" else compression
        self._compress = _compressor(compression)
        self._schemas: list[Any] = []
        self._channels: list[Any] = []
        self._counts: list[int] = []  # messages per channel
        self._attachments: list[Any] = []  # their index records
        self._metadata: list[Any] = []
        self._chunk_index: list[bytes] = []
        self.index_bytes = 0  # of the index at the end, as far as it is known
        self.completed = 0  # messages in complete chunks
        self._chunks = 0
        self._first_time, self._last_time = 0, 0  # of all messages
        self._begin_chunk()

    def start(self, profile: str, library: str) -> None:
        from mcap.records import Header

        self._out.write(_MAGIC)
        self._out.write(_bytes(Header(profile, library)))

    def add_attachment(
        self, name: str, media_type: str, data: bytes, create_time: int = 0, log_time: int = 0
    ) -> None:
        from mcap.records import Attachment, AttachmentIndex

        offset = self._out.tell()
        record = _bytes(Attachment(create_time, log_time, name, media_type, data))
        self._out.write(record)
        self._attachments.append(
            AttachmentIndex(offset, len(record), log_time, create_time, len(data), name, media_type)
        )

    def add_metadata(self, name: str, content: Mapping[str, str]) -> None:
        from mcap.records import Metadata, MetadataIndex

        offset = self._out.tell()
        record = _bytes(Metadata(name, dict(content)))
        self._out.write(record)
        self._metadata.append(MetadataIndex(offset, len(record), name))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """The id of the new schema."""
        from mcap.records import Schema

        schema = Schema(len(self._schemas) + 1, data, encoding, name)
        self._schemas.append(schema)
        self._add_record(_bytes(schema))
        return int(schema.id)

    def add_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """The id of the new channel."""
        from mcap.records import Channel

        channel = Channel(len(self._channels) + 1, topic, encoding, dict(metadata), schema)
        self._channels.append(channel)
        self._counts.append(0)
        self._add_record(_bytes(channel))
        return int(channel.id)

    def _add_record(self, data: bytes) -> None:
        self._parts.append(data)
        self._size += len(data)
        self.index_bytes += len(data)  # repeated at the end

    def add_message(
        self, channel: int, log_time: int, data: bytes, publish_time: int, sequence: int
    ) -> None:
        """Times in ns; `channel` as `add_channel` gave it."""
        size = len(data)
        self._parts.append(
            _MESSAGE_HEAD.pack(
                _MESSAGE, _MESSAGE_FIELDS + size, channel, sequence, log_time, publish_time
            )
        )
        self._parts.append(data)
        entries = self._entries.get(channel)
        if entries is None:
            entries = self._entries[channel] = []
        entries += (log_time, self._size)
        self._size += _MESSAGE_HEAD.size + size
        if self._size > self._chunk_bytes:
            self.flush()

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._entries: dict[int, list[int]] = {}  # channel -> time, offset, time, offset, ...

    def flush(self) -> None:
        """Completes the chunk in progress; one without messages waits for them."""
        if not self._entries:
            return
        content = b"".join(self._parts)
        packed = self._compress(content)
        name = self._compression.encode()
        first = min(min(entries[::2]) for entries in self._entries.values())
        last = max(max(entries[::2]) for entries in self._entries.values())
        head = _CHUNK_HEAD.pack(
            _CHUNK, 40 + len(name) + len(packed), first, last, len(content), zlib.crc32(content)
        )
        start = self._out.tell()
        length = len(head) + 12 + len(name) + len(packed)
        self._out.write(b"".join((head, _text(name), struct.pack("<Q", len(packed)), packed)))
        indexes: list[bytes] = []
        offsets, position = [], start + length
        for channel, entries in self._entries.items():
            size = 8 * len(entries)
            index = _INDEX_HEAD.pack(_MESSAGE_INDEX, 6 + size, channel, size)
            indexes += (index, struct.pack(f"<{len(entries)}Q", *entries))
            offsets.append(_OFFSET.pack(channel, position))
            position += len(index) + size
            self._counts[channel - 1] += len(entries) // 2
            self.completed += len(entries) // 2
        self._out.write(b"".join(indexes))
        where = b"".join(offsets)
        tail = struct.pack("<Q", position - start - length) + _text(name)
        tail += struct.pack("<QQ", len(packed), len(content))
        record = _CHUNK_INDEX_HEAD.pack(
            _CHUNK_INDEX, 36 + len(where) + len(tail), first, last, start, length, len(where)
        )
        self._chunk_index.append(record + where + tail)
        self.index_bytes += len(self._chunk_index[-1])
        self._first_time = first if self._chunks == 0 else min(self._first_time, first)
        self._last_time = max(self._last_time, last)
        self._chunks += 1
        self._begin_chunk()

    def finish(self) -> None:
        """The last chunk, the index and the end of the file."""
        from mcap.opcode import Opcode
        from mcap.records import DataEnd, Footer, Statistics, SummaryOffset

        self.flush()
        self._out.write(_bytes(DataEnd(0)))
        counts = {c.id: n for c, n in zip(self._channels, self._counts, strict=True)}
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts={channel: n for channel, n in counts.items() if n},
            chunk_count=self._chunks,
            message_count=sum(self._counts),
            message_end_time=self._last_time,
            message_start_time=self._first_time,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        start = position = self._out.tell()
        checksum = 0
        offsets = []
        for opcode, records in (
            (Opcode.SCHEMA, map(_bytes, self._schemas)),
            (Opcode.CHANNEL, map(_bytes, self._channels)),
            (Opcode.STATISTICS, [_bytes(statistics)]),
            (Opcode.CHUNK_INDEX, self._chunk_index),
            (Opcode.ATTACHMENT_INDEX, map(_bytes, self._attachments)),
            (Opcode.METADATA_INDEX, map(_bytes, self._metadata)),
        ):
            group = b"".join(records)
            if group:
                offsets.append(_bytes(SummaryOffset(opcode, position, len(group))))
            self._out.write(group)
            checksum = zlib.crc32(group, checksum)
            position += len(group)
        self._chunk_index = []
        found = b"".join(offsets)
        self._out.write(found)
        footer = _bytes(Footer(start, position, 0))
        # The footer's checksum counts the summary and the footer up to itself.
        checksum = zlib.crc32(footer[:-4], zlib.crc32(found, checksum))
        self._out.write(footer[:-4] + struct.pack("<I", checksum) + _MAGIC)


def _bytes(record: Any) -> bytes:
    from mcap.data_stream import RecordBuilder

    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())


def _text(encoded: bytes) -> bytes:
    return struct.pack("<I", len(encoded)) + encoded


def _compressor(name: str) -> Callable[[bytes], bytes]:
    """Raises ValueError for an unknown name, ImportError for a missing library."""
    if name == "zstd":
        import zstandard

        # Level 1: CDR packs as small as at the usual 3, in three quarters of the time.
        return zstandard.ZstdCompressor(level=1).compress
    if name == "lz4":
        import lz4.frame

        compress: Callable[[bytes], bytes] = lz4.frame.compress
        return compress
    if name == "none":
        return lambda data: data
    raise ValueError(f"compression {name!r} is not one of {', '.join(COMPRESSIONS)}")
