"""The bag: MCAP files and metadata.yaml, written by a thread of its own.

Every `flush_interval` the chunk in progress is completed and handed to the operating system, so a
killed process loses no more than that. Nothing existing is ever overwritten.
"""

from __future__ import annotations

import importlib.util
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from .bag_file import RESERVE_METADATA, Attachment, BagFile, LogTopic
from .definitions import definition
from .errors import RecordingError
from .log_folder import make_folder
from .mcap_writer import COMPRESSIONS
from .message_queue import Entry, MessageQueue
from .rosbag2 import FileInfo, bag_metadata
from .topics import Qos

_WAKE = 0.01  # s between two looks into the queue; short, so that no burst holds the interpreter
# `write` gives way to the writer's thread when what was given so many flush intervals ago hasn't
# reached the file, and for at most so many s each time.
_BEHIND, _GIVE_WAY = 1.75, 0.5
# A log that may drop writes what it took from the queue for so many flush intervals, then only what
# is never dropped: so a slow disk leaves outputs behind, and not the inputs, hashes and snapshots.
_AT_LENGTH = 0.5
_YIELD_EVERY = 64  # messages written before other threads get a chance
_LOOK = 0.5  # s between two looks whether the folder is still there
_AT_IT = 0.1  # s for what takes the folder away to come to its end
# The index waits in memory for its file's end, and readers look through all of it: at this size a
# new file begins.
_INDEX_BYTES = 2 * 1024 * 1024


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
        new file, by size only once its messages take as much of it as what begins every file;
        `fsync` forces every flush to the disk. Raises RecordingError, and leaves nothing behind then.
        """
        if importlib.util.find_spec("mcap") is None:
            raise RecordingError("recording needs the mcap package: pip install mcap")
        if compression not in COMPRESSIONS:
            raise RecordingError(
                f"compression {compression!r} is not one of {', '.join(COMPRESSIONS)}"
            )
        self.directory = Path(directory)
        self._compression = compression
        self._chunk_bytes, self._flush_interval = chunk_bytes, flush_interval
        self._split_bytes, self._split_duration = split_bytes, split_duration
        self._fsync = fsync
        self._custom_data = dict(custom_data or {})
        self._attachments = list(attachments)
        self._queue = MessageQueue(queue_bytes, policy)
        self._topics: list[LogTopic] = []
        self._counts: list[int] = []
        self._names: list[str] = []  # of the files made
        self._files: list[FileInfo] = []
        self._closing: dict[str, str] = {}
        self._last_time = 0
        self._blocks = policy == "block"
        self._flushed = threading.Condition()
        self._last_flush = self._covered = time.monotonic()  # covered: given before is in the file
        self._waits = 0
        self._last_look = time.monotonic()
        self._given = 0  # messages written so far, and those in hand to be written
        self._before = 0  # messages in the files before the one in hand
        self._unwanted = False
        self.messages = 0  # written to the file
        self.bytes = 0  # their payload
        self.split_count = 0  # files begun after the first
        self.error: str | None = None  # why writing stopped before `close`
        self._folder = make_folder(self.directory)
        try:
            self._begin_file()
            self._write_metadata()
            self.check_room(RESERVE_METADATA)
            self._thread = threading.Thread(target=self._run, name="mcap_log", daemon=True)
            self._thread.start()
        except BaseException as error:
            if self._files:
                self._file.close()
            self._folder.remove([*self._names, "metadata.yaml"])
            if not isinstance(error, OSError):
                raise
            raise RecordingError(
                f"recording folder {self.directory} can't be written ({error.strerror}): choose "
                "another one, or free some space"
            ) from None

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
            "file_bytes": sum(f.size for f in self._files),
            "queued_bytes": self._queue.queued_bytes,
            "dropped": self._queue.dropped,
            "blocked": self._queue.blocked + self._waits,
        }

    def close(self, closing: Mapping[str, str] | None = None) -> None:
        """Writes what is queued, the index and the final metadata. Safe to call again."""
        self._closing.update(closing or {})
        self._queue.close()
        self._thread.join()

    def check_room(self, needed: int) -> None:
        """Raises RecordingError when the disk hasn't so many bytes left; for right after the start."""
        free = self._file.free_bytes
        if free < needed:
            raise RecordingError(
                f"recording folder {self.directory} can't be used: its disk has {free // 1000} kB left, "
                f"and {needed // 1000} kB are needed to begin; free some space or choose another folder"
            )

    def discard(self, others: Sequence[str] = ()) -> None:
        """Ends it and takes it away, with `others` in its folder: for a caller that couldn't begin."""
        self._names += others
        self._unwanted = True
        self.close()

    # -- the writer's thread ----------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._write_until_closed()
        except (OSError, ValueError) as error:
            self._fail(self._sentence(error))
        finally:
            if self._unwanted:
                self._folder.remove([*self._names, "metadata.yaml"])
            self._folder.close()

    def _write_until_closed(self) -> None:
        while True:
            closed = self._queue.closed
            left = self._last_flush + self._flush_interval - time.monotonic()
            entries = self._queue.take(min(_WAKE, max(left, 0.0)))
            taken = time.monotonic()
            self._given = self.messages + len(entries)
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
            if closed or time.monotonic() - self._last_look >= _LOOK:
                self._look()
            if closed:
                self._end_file()
                self._write_metadata()
                return

    def _late(self, taken: float) -> bool:
        return time.monotonic() - taken > _AT_LENGTH * self._flush_interval

    def _essential(self, entries: list[Entry]) -> list[Entry]:
        """What is never dropped; the rest is counted."""
        kept = [entry for entry in entries if entry.topic in self._queue.essential]
        left_out = len(entries) - len(kept)
        self._queue.dropped += left_out
        self._given -= left_out
        return kept

    def _write_entries(self, entries: list[Entry]) -> None:
        for topic, log_time, step, data in entries:
            if self._must_split(log_time):
                self._look()
                self._end_file()
                self._begin_file()
                self._write_metadata()
                self.split_count += 1
            self._file.add(topic, self._topics, log_time, step, data)
            self._counts[topic] += 1
            self.messages += 1
            self.bytes += len(data)
            if self._file.pending > self._chunk_bytes:
                self._commit()

    def _must_split(self, log_time: int) -> bool:
        file = self._file
        if file.info.start is None:
            return False
        if file.index_bytes >= _INDEX_BYTES:
            return True
        # A large scene, which begins every file, must not make a file of each message.
        full = None if self._split_bytes is None else max(self._split_bytes, 2 * file.start_bytes)
        if full is not None and file.size >= full:
            return True
        lasts = log_time - file.info.start
        return self._split_duration is not None and lasts >= self._split_duration * 1e9

    def _begin_file(self) -> None:
        name = f"{self.directory.name}_{len(self._files)}.mcap"
        descriptor = self._folder.create(name)
        self._names.append(name)
        self._file = BagFile(
            descriptor, name, self._compression, self._chunk_bytes, self._attachments,
            self._custom_data,
        )  # fmt: skip
        self._before, self._counts_before = self.messages, list(self._counts)
        self._files.append(self._file.info)

    def _flush(self) -> None:
        self._file.complete_chunk()
        self._commit()
        if self._fsync:
            self._file.sync()

    def _commit(self) -> None:
        if self._file.pending > 0 and not self._file.has_room:
            self._stop_for_space()
        self._file.commit()

    def _stop_for_space(self) -> None:
        """The disk is nearly full: closes the file while it still can."""
        self._closing["stopped"] = "disk full"
        self._end_file()
        self._write_metadata()
        raise _Stopped(
            f"recording stopped: the disk that holds {self.directory} is full; everything up to "
            f"{self._last_time * 1e-9:.3f} s is kept and readable. Free some space and start a new "
            "recording"
        )

    def _look(self) -> None:
        """Raises _Stopped when the folder or the file in hand is no longer where it was."""
        self._last_look = time.monotonic()
        if self._in_place():
            return
        time.sleep(_AT_IT)
        if self._in_place():
            return
        if self._file.status.st_nlink > 0:
            self._stop_for_move()
        self._stop_for_removal()

    def _in_place(self) -> bool:
        try:
            here = self._folder.holds(self._file.info.path, self._file.status)
            return here and self._folder.in_place
        except PermissionError:  # not to be told; written it can be, the file is open
            return True

    def _stop_for_move(self) -> None:
        """What moved is open and goes where it goes: closes the file there."""
        file_only = self._folder.in_place
        if not self._queue.closed:
            self._closing["stopped"] = "file moved" if file_only else "folder moved"
        self._end_file()
        self._write_metadata()
        until = f"up to {self._last_time * 1e-9:.3f} s"
        if file_only:
            raise _Stopped(
                f"recording stopped: {self.directory / self._files[-1].path} was moved away while it "
                f"was written; it is whole, {until}: move it back to read the recording"
            )
        place = self._folder.place
        raise _Stopped(
            f"recording stopped: the folder {self.directory} was moved or renamed while it was "
            f"recorded to; everything {until} is kept and readable in "
            f"{place or 'the place where it is now'}"
        )

    def _stop_for_removal(self) -> None:
        """The file in hand is deleted; those before it may be left."""
        self._file.close()
        self._file.kept = 0
        path = self.directory / self._files.pop().path
        self._files = [info for info in self._files if self._folder.holds(info.path)]
        self._before = sum(info.message_count for info in self._files)
        if not self._files:
            what = path if self._folder.in_place else f"the folder {self.directory}"
            raise _Stopped(
                f"recording stopped: {what} was removed while it was recorded to; nothing is left "
                "of the recording there"
            )
        came_later = len(self._counts) - len(self._counts_before)
        self._counts[:] = [*self._counts_before, *[0] * came_later]
        self._closing["stopped"] = "file removed"
        self._write_metadata()
        raise _Stopped(
            f"recording stopped: {path} was removed while it was written; the files before it, up to "
            f"{self._files[-1].end * 1e-9:.3f} s, are kept and readable"
        )

    def _end_file(self) -> None:
        self._last_time = self._file.info.end
        self._closing["dropped"] = str(self._queue.dropped)
        self._file.finish(self._closing)

    def _write_metadata(self) -> None:
        topics = [(*t, count) for t, count in zip(self._topics, self._counts, strict=True)]
        custom = {**self._custom_data, **self._closing}
        text = bag_metadata(self._files, [t for t in topics if t[3] > 0], custom)
        self._folder.replace("metadata.yaml", text)

    def _fail(self, sentence: str) -> None:
        self.error = sentence
        self._queue.close()
        with self._flushed:
            self._flushed.notify_all()
        # What was queued, in hand, or in a chunk that didn't reach the file.
        kept = self._before + self._file.kept
        self._queue.dropped += len(self._queue.take(0)) + max(self._given, self.messages) - kept
        self.messages = kept
        self._file.close()

    def _sentence(self, error: Exception) -> str:
        if isinstance(error, _Stopped):
            return str(error)
        if not self._file.finished:
            try:
                self._look()
            except _Stopped as stopped:
                return str(stopped)
            except (OSError, ValueError):
                pass  # the first error tells enough
        reason = getattr(error, "strerror", None) or str(error)
        kept = (
            f"what was written before can be read after `rb_physics recover {self.directory}`"
            if self._before + self._file.kept > 0
            else "nothing of the run could be kept"
        )
        return f"recording stopped: {self.directory} can't be written ({reason}); {kept}"


class _Stopped(ValueError):
    """The sentence to show; the file is closed already."""
