"""One .mcap file of a bag while it is written. Bytes reach it in `commit`: all of them or none."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from .definitions import definition
from .mcap_writer import McapWriter
from .rosbag2 import FileInfo, channel_metadata
from .topics import Qos

_RESERVE_CHUNKS = 4  # room for the chunks in hand, kept free on the disk beside the file's index
RESERVE_METADATA = 64 * 1024  # bytes; and for statistics and metadata.yaml


class LogTopic(NamedTuple):
    """A topic of the bag."""

    name: str
    type: str
    qos: Qos


class Attachment(NamedTuple):
    """A file stored inside every .mcap file of the bag."""

    name: str
    media_type: str
    data: bytes


class _Stream:
    """The file below the MCAP writer."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self._pending = bytearray()
        self.committed = 0  # bytes in the file

    def write(self, data: bytes) -> int:
        self._pending += data
        return len(data)

    def tell(self) -> int:
        return self.committed + len(self._pending)

    @property
    def pending(self) -> int:
        return len(self._pending)

    def commit(self) -> None:
        """Raises OSError and leaves the file as it was before when the bytes don't fit."""
        view = memoryview(self._pending)
        written = 0
        try:
            while written < len(view):
                written += os.write(self.descriptor, view[written:])
        except OSError:
            os.ftruncate(self.descriptor, self.committed)
            os.lseek(self.descriptor, self.committed, os.SEEK_SET)
            raise
        finally:
            view.release()
        self.committed += written
        self._pending.clear()

    def close(self) -> None:
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1


class BagFile:
    """Begun when it is made; then `add`, `complete_chunk` and `commit`, and `finish`. Raises OSError."""

    def __init__(
        self,
        descriptor: int,
        name: str,
        compression: str,
        chunk_bytes: int,
        attachments: Sequence[Attachment],
        notes: Mapping[str, str],
    ) -> None:
        self.info = FileInfo(name)
        self.finished = False  # or tried to be
        self.kept = 0  # messages that can be read from the file as it is
        self._stream, self._chunk_bytes = _Stream(descriptor), chunk_bytes
        self._schemas: dict[str, int] = {}
        self._channels: dict[int, int] = {}
        self._writer = McapWriter(self._stream, compression, chunk_bytes)
        try:
            self._writer.start(profile="ros2", library="rb_physics")
            for attachment in attachments:
                self._writer.add_attachment(*attachment)
            self._writer.add_metadata("rb_physics", notes)
            self._put()
            self.start_bytes = self.size  # scene, topics, notes: before any message
        except BaseException:
            self.close()
            raise

    def add(
        self, topic: int, known: Sequence[LogTopic], log_time: int, step: int, data: bytes
    ) -> None:
        """One message of the topic with that row in `known`; it waits in memory for its chunk."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channels[topic] = self._register(known[topic])
        self._writer.add_message(channel, log_time, data, log_time, step & 0xFFFFFFFF)
        info = self.info
        if info.start is None:
            info.start = log_time
        info.end = max(info.end, log_time)
        info.message_count += 1

    def _register(self, topic: LogTopic) -> int:
        schema = self._schemas.get(topic.type)
        if schema is None:
            text = definition(topic.type).text.encode()
            schema = self._writer.add_schema(topic.type, "ros2msg", text)
            self._schemas[topic.type] = schema
        metadata = channel_metadata(topic.type, topic.qos)
        return self._writer.add_channel(topic.name, "cdr", schema, metadata)

    def complete_chunk(self) -> None:
        """Completes the chunk in progress, for the next `commit`."""
        self._writer.flush()

    def commit(self) -> None:
        """Hands what is complete to the operating system."""
        if self._stream.pending > 0:
            self._put()

    def sync(self) -> None:
        """Forces it to the disk."""
        os.fdatasync(self._stream.descriptor)

    def finish(self, closing: Mapping[str, str]) -> None:
        """The last messages, the notes and the index; then it is closed."""
        self.finished = True
        self._writer.add_metadata("rb_physics_closing", closing)
        self._writer.finish()
        self._put()
        self.close()

    def close(self) -> None:
        """As it is: without its end it has no index, but whole chunks. Safe to call again."""
        self.finished = True
        self._stream.close()

    def _put(self) -> None:
        self._stream.commit()
        self.info.size = self._stream.committed
        self.kept = self._writer.completed

    @property
    def status(self) -> os.stat_result:
        return os.fstat(self._stream.descriptor)

    @property
    def free_bytes(self) -> int:
        """Of its disk."""
        status = os.fstatvfs(self._stream.descriptor)
        return status.f_bavail * status.f_frsize

    @property
    def has_room(self) -> bool:
        """Whether the disk holds what waits and, beside a reserve, the end of the file."""
        needed = self._writer.index_bytes + 10 * len(self._channels) + RESERVE_METADATA
        needed += _RESERVE_CHUNKS * self._chunk_bytes
        return self.free_bytes - self._stream.pending >= needed

    @property
    def pending(self) -> int:
        """Bytes that wait for `commit`."""
        return self._stream.pending

    @property
    def size(self) -> int:
        """Bytes, those that wait included."""
        return self._stream.tell()

    @property
    def index_bytes(self) -> int:
        """Of the index that waits for the end."""
        return self._writer.index_bytes
