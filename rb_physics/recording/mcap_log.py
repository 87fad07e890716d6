"""The bag: MCAP files and metadata.yaml, written by a thread of its own.

Every `flush_interval` the chunk in progress is completed and handed to the operating system, so a
killed process loses no more than that. Nothing existing is ever overwritten.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from .definitions import definition
from .mcap_writer import COMPRESSIONS, McapWriter
from .message_queue import Entry, MessageQueue
from .rosbag2 import FileInfo, bag_metadata, channel_metadata, write_atomically
from .topics import Qos

_WAKE = 0.01  # s between two looks into the queue; short, so that no burst holds the interpreter
# `write` gives way to the writer's thread when what was given so many flush intervals ago hasn't
# reached the file, and for at most so many s each time.
_BEHIND, _GIVE_WAY = 1.75, 0.5
# A log that may drop writes what it took from the queue for so many flush intervals, then only what
# is never dropped: so a slow disk leaves outputs behind, and not the inputs, hashes and snapshots.
_AT_LENGTH = 0.5
_YIELD_EVERY = 64  # messages written before other threads get a chance
_RESERVE_CHUNKS = 4  # room for the chunks in hand, kept free on the disk beside the file's index
# The index waits in memory for its file's end, and readers look through all of it: at this size a
# new file begins.
_INDEX_BYTES = 2 * 1024 * 1024


class RecordingError(ValueError):
    """A recording that can't be made or read; one sentence that says what to do."""


class FolderExistsError(RecordingError):
    """The folder of a recording exists already."""


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
    """The file below the MCAP writer. Bytes reach it in `commit`: all of them or none."""

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        self._pending = bytearray()
        self.committed = 0  # bytes in the file

    def write(self, data: bytes) -> int:
        self._pending += data
        return len(data)

    def tell(self) -> int:
        return self.committed + len(self._pending)

    def commit(self) -> None:
        """Raises OSError and leaves the file as it was before when the bytes don't fit."""
        view = memoryview(self._pending)
        written = 0
        try:
            while written < len(view):
                written += os.write(self._descriptor, view[written:])
        except OSError:
            os.ftruncate(self._descriptor, self.committed)
            os.lseek(self._descriptor, self.committed, os.SEEK_SET)
            raise
        finally:
            view.release()
        self.committed += written
        self._pending.clear()

    def sync(self) -> None:
        os.fdatasync(self._descriptor)

    def free_bytes(self) -> int:
        status = os.fstatvfs(self._descriptor)
        return status.f_bavail * status.f_frsize

    @property
    def pending(self) -> int:
        return len(self._pending)

    def close(self) -> None:
        os.close(self._descriptor)


class McapLog:
    """Writes one bag folder. `write` may be called from any thread, `close` once."""

    def __init__(
        self,
        directory: str | Path,
        *,
        custom_data: Mapping[str, str] | None = None,
        attachments: Sequence[Attachment] = (),
        compression: str = "zstd",
        chunk_bytes: int = 256 * 1024,
        flush_interval: float = 0.04,
        queue_bytes: int = 64 * 1024 * 1024,
        policy: str = "block",
        split_bytes: int | None = 256 * 1024 * 1024,
        split_duration: float | None = None,
        fsync: bool = False,
    ) -> None:
        """Makes the folder (and its parents) and starts the writer.

        `flush_interval` s of wall time; `split_bytes` and `split_duration` (s of log time) begin a
        new file; `fsync` forces every flush to the disk. Raises RecordingError.
        """
        if importlib.util.find_spec("mcap") is None:
            raise RecordingError("recording needs the mcap package: pip install mcap")
        if compression not in COMPRESSIONS:
            raise RecordingError(
                f"compression {compression!r} is not one of {', '.join(COMPRESSIONS)}"
            )
        self.directory = Path(directory)
        _make_folder(self.directory)
        self._compression = compression
        self._chunk_bytes, self._flush_interval = chunk_bytes, flush_interval
        self._split_bytes, self._split_duration = split_bytes, split_duration
        self._fsync = fsync
        self._custom_data = dict(custom_data or {})
        self._attachments = list(attachments)
        self._queue = MessageQueue(queue_bytes, policy)
        self._topics: list[LogTopic] = []
        self._counts: list[int] = []
        self._files: list[FileInfo] = []
        self._closing: dict[str, str] = {}
        self._last_time = 0
        self._blocks = policy == "block"
        self._flushed = threading.Condition()
        self._last_flush = self._covered = time.monotonic()  # covered: given before is in the file
        self._waits = 0
        self._stopped = False  # the file was closed before `close`
        self.messages = 0  # written to the file
        self.bytes = 0  # their payload
        self.split_count = 0  # files begun after the first
        self.error: str | None = None  # why writing stopped before `close`
        try:
            self._begin_file()
            self._write_metadata()
        except OSError as error:
            raise RecordingError(self._sentence(error)) from None
        self._thread = threading.Thread(target=self._run, name="mcap_log", daemon=True)
        self._thread.start()

    # -- called by the simulation -----------------------------------------------------------------

    def add_topic(self, name: str, type_name: str, qos: Qos, essential: bool = False) -> int:
        """The id to write with. `essential` topics are never dropped. Raises UnknownTypeError."""
        definition(type_name)  # an unknown type is found out here, not in the writer's thread
        topic = len(self._topics)
        self._counts.append(0)
        self._topics.append(LogTopic(name, type_name, qos))
        if essential:
            self._queue.essential.add(topic)
        return topic

    def write(self, entries: list[Entry]) -> None:
        """Queues messages. After an error they are counted as dropped.

        On a machine too busy for the writer's thread to keep its time, a log that may block lets
        it catch up first: else the run would get ahead of what a killed process leaves behind.
        """
        if self.error is not None or self._queue.closed:
            self._queue.dropped += len(entries)
            return
        self._queue.put(entries)
        if self._blocks and self._behind():
            with self._flushed:
                self._waits += 1
                self._flushed.wait_for(lambda: not self._behind() or self._queue.closed, _GIVE_WAY)

    def _behind(self) -> bool:
        return time.monotonic() - self._covered > _BEHIND * self._flush_interval

    @property
    def closed(self) -> bool:
        return self._queue.closed

    @property
    def counters(self) -> dict[str, int]:
        return {
            "messages": self.messages,
            "bytes": self.bytes,
            "file_bytes": sum(f.stat().st_size for f in self.directory.glob("*.mcap")),
            "queued_bytes": self._queue.queued_bytes,
            "dropped": self._queue.dropped,
            "blocked": self._queue.blocked + self._waits,
        }

    def close(self, closing: Mapping[str, str] | None = None) -> None:
        """Writes what is queued, the index and the final metadata. Safe to call again."""
        self._closing.update(closing or {})
        self._queue.close()
        self._thread.join()

    # -- the writer's thread ----------------------------------------------------------------------

    def _run(self) -> None:
        while True:
            closed = self._queue.closed
            left = self._last_flush + self._flush_interval - time.monotonic()
            entries = self._queue.take(min(_WAKE, max(left, 0.0)))
            taken = time.monotonic()
            try:
                for start in range(0, len(entries), _YIELD_EVERY):
                    some = entries[start : start + _YIELD_EVERY]
                    if not self._blocks and self._late(taken):
                        some = self._essential(some)
                    self._write_entries(some)
                    time.sleep(0)
                if time.monotonic() - self._last_flush >= self._flush_interval:
                    self._flush()
                    self._last_flush = time.monotonic()
                    with self._flushed:
                        self._covered = taken
                        self._flushed.notify_all()
                if closed:
                    self._end_file()
                    self._write_metadata()
                    return
            except (OSError, ValueError) as error:
                self._fail(self._sentence(error))
                return

    def _late(self, taken: float) -> bool:
        return time.monotonic() - taken > _AT_LENGTH * self._flush_interval

    def _essential(self, entries: list[Entry]) -> list[Entry]:
        """What is never dropped; the rest is counted."""
        kept = [entry for entry in entries if entry.topic in self._queue.essential]
        self._queue.dropped += len(entries) - len(kept)
        return kept

    def _write_entries(self, entries: list[Entry]) -> None:
        for topic, log_time, step, data in entries:
            if self._must_split(log_time):
                self._end_file()
                self._begin_file()
                self._write_metadata()
                self.split_count += 1
            channel = self._channels.get(topic)
            if channel is None:
                channel = self._register(topic)
            self._writer.add_message(channel, log_time, data, log_time, step & 0xFFFFFFFF)
            info = self._files[-1]
            if info.start is None:
                info.start = log_time
            info.end = max(info.end, log_time)
            info.message_count += 1
            self._counts[topic] += 1
            self.messages += 1
            self.bytes += len(data)
            if self._stream.pending > self._chunk_bytes:
                self._commit()

    def _must_split(self, log_time: int) -> bool:
        info = self._files[-1]
        if info.start is None:
            return False
        if self._writer.index_bytes >= _INDEX_BYTES:
            return True
        if self._split_bytes is not None and self._stream.tell() >= self._split_bytes:
            return True
        return (
            self._split_duration is not None and log_time - info.start >= self._split_duration * 1e9
        )

    def _register(self, topic: int) -> int:
        name, type_name, qos = self._topics[topic]
        schema = self._schemas.get(type_name)
        if schema is None:
            text = definition(type_name).text.encode()
            schema = self._writer.add_schema(type_name, "ros2msg", text)
            self._schemas[type_name] = schema
        metadata = channel_metadata(type_name, qos)
        channel = self._writer.add_channel(name, "cdr", schema, metadata)
        self._channels[topic] = channel
        return channel

    def _begin_file(self) -> None:
        path = f"{self.directory.name}_{len(self._files)}.mcap"
        self._stream = _Stream(self.directory / path)
        self._files.append(FileInfo(path))
        self._schemas: dict[str, int] = {}
        self._channels: dict[int, int] = {}
        self._writer = McapWriter(self._stream, self._compression, self._chunk_bytes)
        self._writer.start(profile="ros2", library="rb_physics")
        for attachment in self._attachments:
            self._writer.add_attachment(*attachment)
        self._writer.add_metadata("rb_physics", self._custom_data)
        self._stream.commit()

    def _flush(self) -> None:
        self._writer.flush()
        self._commit()
        if self._fsync:
            self._stream.sync()

    def _commit(self) -> None:
        if self._stream.pending == 0:
            return
        # Beside the index: statistics, 10 bytes per channel, and the last metadata.
        needed = self._writer.index_bytes + 10 * len(self._channels) + 64 * 1024
        needed += _RESERVE_CHUNKS * self._chunk_bytes
        if self._stream.free_bytes() - self._stream.pending < needed:
            self._stop_for_space()
        self._stream.commit()

    def _stop_for_space(self) -> None:
        """The disk is nearly full: closes the file while it still can."""
        self._closing["stopped"] = "disk full"
        self._end_file()
        self._write_metadata()
        self._stopped = True
        raise _DiskFull(
            f"recording stopped: the disk that holds {self.directory} is full; everything up to "
            f"{self._last_time * 1e-9:.3f} s is kept and readable. Free some space and start a new "
            "recording"
        )

    def _end_file(self) -> None:
        self._last_time = self._files[-1].end
        self._closing["dropped"] = str(self._queue.dropped)
        self._writer.add_metadata("rb_physics_closing", self._closing)
        self._writer.finish()
        self._stream.commit()
        self._stream.close()

    def _write_metadata(self) -> None:
        topics = [(*t, count) for t, count in zip(self._topics, self._counts, strict=True)]
        custom = {**self._custom_data, **self._closing}
        text = bag_metadata(self._files, [t for t in topics if t[3] > 0], custom)
        write_atomically(self.directory / "metadata.yaml", text)

    def _fail(self, sentence: str) -> None:
        self.error = sentence
        self._queue.close()
        with self._flushed:
            self._flushed.notify_all()
        self._queue.dropped += len(self._queue.take(0))
        if not self._stopped:
            # The file has no index now, but every chunk committed before is complete.
            with contextlib.suppress(OSError):
                self._stream.close()

    def _sentence(self, error: Exception) -> str:
        if isinstance(error, _DiskFull):
            return str(error)
        reason = getattr(error, "strerror", None) or str(error)
        return (
            f"recording stopped: {self.directory} can't be written ({reason}); what was written "
            f"before can be read after `rb_physics recover {self.directory}`"
        )


class _DiskFull(ValueError):
    """The sentence to show; the file is closed already."""


def _make_folder(directory: Path) -> None:
    """Makes a new folder; RecordingError when it exists or can't be made."""
    try:
        if directory.parent.exists() and not directory.parent.is_dir():
            raise NotADirectoryError(None, f"{directory.parent} is a file")
        directory.parent.mkdir(parents=True, exist_ok=True)
        directory.mkdir()
    except FileExistsError:
        raise FolderExistsError(
            f"recording folder {directory} exists already and is never overwritten: choose another "
            "name or remove it"
        ) from None
    except OSError as error:
        raise RecordingError(
            f"recording folder {directory} can't be made ({error.strerror}): choose a folder you "
            "may write to"
        ) from None
