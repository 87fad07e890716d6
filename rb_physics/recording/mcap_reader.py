"""Reading one MCAP file record by record: whole, torn off or damaged, in bounded memory.

The mcap package reads whole files and trusts them. Here a file may end anywhere and hold any bytes:
no record or chunk takes more memory than `RECORD_LIMIT`, whatever it claims.

Source: MCAP format specification, https://mcap.dev/spec
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from io import BytesIO
from typing import IO, Any, NamedTuple

import numpy as np

RECORD_LIMIT = 256 * 1024 * 1024  # bytes one record, or the content of one chunk, may claim
DAMAGE = (ValueError, struct.error)  # what damaged bytes lead to, beside mcap's own McapError
_BLOCK = 1024 * 1024  # bytes read at once
_MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")  # opcode, length
_MESSAGE = struct.Struct("<BQHIQ")  # opcode, length, channel, sequence, log_time
_MESSAGE_FIELDS = 22  # bytes of channel, sequence and both times
_FOOTER = struct.Struct("<BQQQI8s")  # opcode, length, summary, offsets, CRC, magic
_CHUNK_INDEX = struct.Struct("<QQQQI")  # first and last time, offset and length, bytes of offsets
_OFFSET = np.dtype([("channel", "<u2"), ("offset", "<u8")])  # of a message index


class LogMessage(NamedTuple):
    """One message of a recording."""

    topic: str
    type: str
    log_time: int  # ns
    step: int  # as the recorder wrote it
    data: bytes


class IndexedChunk(NamedTuple):
    """Where a chunk lies in its file, and whose messages are in it."""

    first_time: int  # ns
    last_time: int  # ns
    offset: int
    length: int  # bytes of its record
    table: bytes  # of _OFFSET

    @property
    def channels(self) -> set[int]:
        """Ids of those with messages in it."""
        return set(np.frombuffer(self.table, _OFFSET)["channel"].tolist())


class DamagedChunk(NamedTuple):
    """Stands where a chunk can't be read."""

    error: Exception


class DamagedAttachment(NamedTuple):
    """Stands where the checksum of an attachment is wrong."""

    name: str


class Summary(NamedTuple):
    """What the end of a finished file says about it."""

    definitions: list[Any]  # its schemas and channels
    chunks: list[IndexedChunk]  # in the order of the file


def top_level_records(file: IO[bytes]) -> Iterator[tuple[Any, int]]:
    """The records that matter here, each with the offset behind it; indexes are passed over.

    Damaged attachments come as `DamagedAttachment`. Ends behind the footer. Raises ValueError, struct.error or McapError where the file is torn or
    damaged; never asks for more memory than the file is long.
    """
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode

    kinds: dict[int, Any] = {
        Opcode.ATTACHMENT: records.Attachment,
        Opcode.CHANNEL: records.Channel,
        Opcode.CHUNK: records.Chunk,
        Opcode.FOOTER: records.Footer,
        Opcode.METADATA: records.Metadata,
        Opcode.SCHEMA: records.Schema,
    }
    size = os.fstat(file.fileno()).st_size
    if file.read(len(_MAGIC)) != _MAGIC:
        raise ValueError("not an MCAP file")
    offset = len(_MAGIC)
    block, start = b"", offset  # bytes of the file in hand, and where they begin
    while True:
        position = offset - start
        if position + _HEAD.size > len(block):
            file.seek(offset)
            block, start, position = file.read(_BLOCK), offset, 0
        opcode, length = _HEAD.unpack_from(block, position)
        offset += _HEAD.size + length
        if length > min(RECORD_LIMIT, size - offset + length):
            raise ValueError(f"a record claims {length} bytes")
        if opcode not in kinds and opcode != Opcode.MESSAGE:
            continue
        position += _HEAD.size
        if position + length > len(block):
            file.seek(offset - length)
            block, start, position = file.read(max(length, _BLOCK)), offset - length, 0
        content = block[position : position + length]
        stream = ReadDataStream(BytesIO(content))
        if opcode == Opcode.MESSAGE:
            yield records.Message.read(stream, length), offset
        elif opcode == Opcode.ATTACHMENT:
            yield _attachment(content), offset
        else:
            yield kinds[opcode].read(stream), offset
            if opcode == Opcode.FOOTER:
                return


def _attachment(content: bytes) -> Any:
    """The attachment, or what stands for a damaged one."""
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.records import Attachment

    checksum = int.from_bytes(content[-4:], "little")
    whole = checksum in (0, zlib.crc32(content[:-4]))
    try:
        attachment = Attachment.read(ReadDataStream(BytesIO(content)))
    except (McapError, *DAMAGE):
        return DamagedAttachment("")
    return attachment if whole else DamagedAttachment(attachment.name)


def read_summary(file: IO[bytes]) -> Summary | None:
    """None where the file has no whole summary: it is torn off, or was written without one."""
    from mcap.opcode import Opcode

    total = os.fstat(file.fileno()).st_size
    if total < _FOOTER.size + len(_MAGIC):
        return None
    file.seek(total - _FOOTER.size)
    opcode, length, start, _, checksum, magic = _FOOTER.unpack(file.read(_FOOTER.size))
    if (opcode, length, magic) != (Opcode.FOOTER, 20, _MAGIC) or not 0 < start < total:
        return None
    if total - start > RECORD_LIMIT:
        return None
    file.seek(start)
    data = file.read(total - start)
    if checksum not in (0, zlib.crc32(data[: -len(_MAGIC) - 4])):
        return None
    summary = Summary([], [])
    position, end = 0, len(data) - _FOOTER.size
    while position + _HEAD.size <= end:
        opcode, length = _HEAD.unpack_from(data, position)
        position += _HEAD.size
        if length > end - position:
            return None
        if opcode == Opcode.CHUNK_INDEX and length >= _CHUNK_INDEX.size:
            first, last, offset, size, of = _CHUNK_INDEX.unpack_from(data, position)
            if of > length - _CHUNK_INDEX.size or of % _OFFSET.itemsize:
                return None
            where = position + _CHUNK_INDEX.size
            table = data[where : where + of]
            summary.chunks.append(IndexedChunk(first, last, offset, size, table))
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            content = data[position : position + length]
            summary.definitions.append(_definition(opcode == Opcode.SCHEMA, content))
        position += length
    return summary


@lru_cache(4096)  # every file of a recording repeats them
def _definition(schema: bool, content: bytes) -> Any:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Channel, Schema

    return (Schema if schema else Channel).read(ReadDataStream(BytesIO(content)))


def chunk_at(file: IO[bytes], place: IndexedChunk) -> Any:
    """The chunk an index speaks of, still compressed. Raises ValueError, struct.error, McapError."""
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Chunk

    if not _HEAD.size < place.length <= RECORD_LIMIT:
        raise ValueError(f"the index claims {place.length} bytes for it")
    file.seek(place.offset)
    data = file.read(place.length)
    opcode, length = _HEAD.unpack_from(data)
    if opcode != Opcode.CHUNK or length != len(data) - _HEAD.size:
        raise ValueError("it is not where the index says")
    return Chunk.read(ReadDataStream(BytesIO(data[_HEAD.size :])))


def decompressed(chunk: Any) -> Any:
    """The chunk with its data uncompressed, never more than it announces. Raises ValueError."""
    size, data = chunk.uncompressed_size, chunk.data
    if size > RECORD_LIMIT:
        raise ValueError(f"it claims {size} bytes")
    if chunk.compression == "zstd":
        data = _unpack_zstd(data, size)
    elif chunk.compression == "lz4":
        import lz4.frame

        try:
            data = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        except (RuntimeError, EOFError) as error:
            raise ValueError(str(error)) from None
    elif chunk.compression != "":
        raise ValueError(f"its compression {chunk.compression!r} is not known")
    if len(data) != size:
        raise ValueError(f"it holds {len(data)} bytes instead of {size}")
    if chunk.uncompressed_crc != 0 and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("its checksum is wrong")
    return replace(chunk, compression="", data=data)


def _unpack_zstd(data: bytes, size: int) -> bytes:
    import zstandard

    try:
        unpacker = zstandard.ZstdDecompressor(max_window_size=2**27)
        if zstandard.frame_content_size(data) == size:  # the usual, and the quick way
            return unpacker.decompress(data)
        with unpacker.stream_reader(data) as reader:
            return reader.read(size + 1)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None


def check_records(data: bytes) -> None:
    """Raises ValueError unless the bytes of a chunk are records of some kind, end to end."""
    position = 0
    while position < len(data):
        opcode, length = _HEAD.unpack_from(data, position)
        if opcode == 0:
            raise ValueError("a record of no kind")
        position += _HEAD.size + length
    if position > len(data):
        raise ValueError("a record is longer than its chunk")


def messages_of_chunk(
    data: bytes,
    channels: dict[int, tuple[str, str] | None],
    learn: Callable[[Any], None],
    not_before: int = 0,
) -> Iterator[LogMessage]:
    """The wanted messages; the others are passed over without making objects of them.

    `channels`: id -> (topic, type), None where it isn't wanted; `learn` takes the schemas and
    channels that come by, and puts them there.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Schema

    position, end = 0, len(data)
    unpack, wanted, message = _MESSAGE.unpack_from, channels.get, int(Opcode.MESSAGE)
    fixed = _HEAD.size + _MESSAGE_FIELDS
    while position < end:
        if end - position >= fixed and data[position] == message:
            _, length, channel, sequence, log_time = unpack(data, position)
            start = position
            position += _HEAD.size + length
            if position > end or length < _MESSAGE_FIELDS:
                raise ValueError("a record is longer than its chunk")
            known = wanted(channel)
            if known is not None and log_time >= not_before:
                topic, kind = known
                yield LogMessage(topic, kind, log_time, sequence, data[start + fixed : position])
            continue
        opcode, length = _HEAD.unpack_from(data, position)
        if opcode == 0:  # no record has it; zeros would be millions of records of no length
            raise ValueError("a record of no kind")
        start = position + _HEAD.size
        position = start + length
        if position > end:
            raise ValueError("a record is longer than its chunk")
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            stream = ReadDataStream(BytesIO(data[start:position]))
            learn((Schema if opcode == Opcode.SCHEMA else Channel).read(stream))
