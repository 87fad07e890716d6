"""Reading a recording back, finished or torn off, and never outside its folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO, Any

from .bag_folder import find_files, read_metadata
from .errors import RecordingError
from .lost_spans import LostSpan, LostSpans
from .mcap_reader import (
    DAMAGE,
    DamagedAttachment,
    DamagedChunk,
    IndexedChunk,
    LogMessage,
    Summary,
    check_records,
    chunk_at,
    decompressed,
    messages_of_chunk,
    read_summary,
    top_level_records,
)


class _Channels:
    """What the channels of one file are called, as its records tell it."""

    def __init__(self, topics: set[str] | None) -> None:
        self._topics = topics
        self._schemas: dict[int, str] = {}
        self.wanted: dict[int, tuple[str, str] | None] = {}  # id -> (topic, type); None: not wanted

    def learn(self, record: Any) -> None:
        """Takes schemas and channels; passes other records over."""
        from mcap.records import Channel, Schema

        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            wanted = self._topics is None or record.topic in self._topics
            name = (record.topic, self._schemas.get(record.schema_id, ""))
            self.wanted[record.id] = name if wanted else None


@contextmanager
def damage_told(log: Recording) -> Iterator[None]:
    """Turns what damaged or foreign content leads to into one RecordingError."""
    try:
        yield
    except RecordingError:
        raise
    except (
        AttributeError, IndexError, KeyError, OverflowError, RecursionError, TypeError, ValueError,
    ) as error:  # fmt: skip
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise RecordingError(f"{log.directory} is damaged or of other software ({what})") from None


class Recording:
    """A bag folder. Raises RecordingError when it isn't one."""

    def __init__(self, directory: str | Path) -> None:
        self.directory = Path(directory)
        if not self.directory.is_dir():
            what = "is a file" if self.directory.exists() else "does not exist"
            raise RecordingError(f"{directory} {what}; give the folder of a recording")
        self.metadata = read_metadata(self.directory)
        self.files = find_files(self.directory, self.metadata)
        self.torn: list[Path] = []  # files without an end; this and the next two after reading
        self.torn_bytes = 0  # behind the last whole record of those
        self.damaged_chunks = 0
        self.damaged_attachments: list[str] = []
        self.lost: list[LostSpan] = []  # after `messages` that skips what is damaged
        self._summaries: dict[Path, Summary | None] = {}  # of files looked into

    def records(self, skip_damaged: bool = False) -> Iterator[tuple[Path, Any]]:
        """(file, MCAP record) in order, chunks taken apart; a file ends at its end or where it is
        torn (then it is in `torn`).

        Raises RecordingError for a damaged chunk or attachment, or skips it and has it in
        `damaged_chunks` or `damaged_attachments`.
        """
        from mcap.exceptions import McapError
        from mcap.records import Chunk
        from mcap.stream_reader import breakup_chunk

        for path, record in self._whole_records():
            if isinstance(record, DamagedChunk):
                self._damaged(path, skip_damaged, record.error)
                continue
            if isinstance(record, DamagedAttachment):
                self._damaged_attachment(path, skip_damaged, record.name)
                continue
            if not isinstance(record, Chunk):
                yield path, record
                continue
            try:
                check_records(record.data)
                parts = breakup_chunk(record)
            except (McapError, *DAMAGE) as error:
                self._damaged(path, skip_damaged, error)
                continue
            for part in parts:
                yield path, part

    def _whole_records(
        self, topics: set[str] | None = None, start: int = 0
    ) -> Iterator[tuple[Path, Any]]:
        """As `records`, with chunks uncompressed but not taken apart, and what stands for damage.

        Of finished files only the chunks with wanted messages are read, if `topics` or a `start`
        (ns) are given.
        """
        from mcap.exceptions import McapError
        from mcap.records import Chunk, Footer

        self.torn, self.torn_bytes = [], 0
        self.damaged_chunks, self.damaged_attachments = 0, []
        for path in self.files:
            summary = self._summary(path) if topics is not None or start > 0 else None
            if summary is not None:
                yield from self._wanted_records(path, summary, topics, start)
                continue
            complete, good = False, 0
            try:
                with open(path, "rb") as file:
                    for record, end in top_level_records(file):
                        good = end
                        complete = isinstance(record, Footer)
                        if isinstance(record, Chunk):
                            try:
                                record = decompressed(record)
                            except DAMAGE as error:
                                record = DamagedChunk(error)
                        yield path, record
            except OSError as error:
                raise RecordingError(f"{path} can't be read: {error.strerror}") from None
            except RecordingError:
                raise
            except (McapError, *DAMAGE):
                complete = False
            if not complete:
                self.torn.append(path)
                self.torn_bytes += path.stat().st_size - good

    def _wanted_records(
        self, path: Path, summary: Summary, topics: set[str] | None, start: int
    ) -> Iterator[tuple[Path, Any]]:
        """By the index of a finished file: all definitions, then the chunks."""
        channels = _Channels(topics)
        for definition in summary.definitions:
            channels.learn(definition)
            yield path, definition
        wanted = {channel for channel, name in channels.wanted.items() if name is not None}
        places = (
            place
            for place in summary.chunks
            if place.last_time >= start and (topics is None or place.channels & wanted)
        )
        with open(path, "rb") as file:
            if start > 0:  # a look at one moment shouldn't wait for a thread
                for place in places:
                    yield path, self._chunk(file, place)
                return
            # The next chunk is decompressed while this one is made use of.
            with ThreadPoolExecutor(1, "decompress") as ahead:
                coming = None
                for next_place in chain(places, [None]):
                    chunk = coming.result() if coming is not None else None
                    if next_place is not None:
                        coming = ahead.submit(self._chunk, file, next_place)
                    if chunk is not None:
                        yield path, chunk

    def _chunk(self, file: IO[bytes], place: IndexedChunk) -> Any:
        from mcap.exceptions import McapError

        try:
            return decompressed(chunk_at(file, place))
        except (McapError, *DAMAGE) as error:
            return DamagedChunk(error)

    def load_index(self) -> None:
        """Reads the index of every finished file now rather than when it is first looked into."""
        for path in self.files:
            self._summary(path)

    def span(self) -> tuple[int, int] | None:
        """First and last log time, ns; None without messages. Of finished files their index tells."""
        first: int | None = None
        last = 0
        summaries = [self._summary(path) for path in self.files]
        if None in summaries:
            spans = ((m.log_time, m.log_time) for m in self.messages(skip_damaged=True))
        else:
            spans = ((c.first_time, c.last_time) for s in summaries if s for c in s.chunks)
        for start, end in spans:
            first = start if first is None else min(first, start)
            last = max(last, end)
        return (first, last) if first is not None else None

    def _summary(self, path: Path) -> Summary | None:
        from mcap.exceptions import McapError

        if path not in self._summaries:
            try:
                with open(path, "rb") as file:
                    self._summaries[path] = read_summary(file)
            except (McapError, *DAMAGE):
                self._summaries[path] = None
        return self._summaries[path]

    def _damaged(self, path: Path, skip: bool, error: Exception) -> None:
        if not skip:
            raise RecordingError(
                f"a chunk of {path} is damaged ({error}): `rb_physics recover {self.directory}` "
                "keeps the rest"
            )
        self.damaged_chunks += 1

    def _damaged_attachment(self, path: Path, skip: bool, name: str) -> None:
        if not skip:
            raise RecordingError(
                f"the attachment {name or '(its name is lost, too)'} of {path} is damaged: its "
                "checksum is wrong"
            )
        self.damaged_attachments.append(name)

    def messages(
        self, topics: set[str] | None = None, start: int = 0, skip_damaged: bool = False
    ) -> Iterator[LogMessage]:
        """Every message in the order of the log; `topics` None: all; `start`: ns of log time.

        Raises RecordingError for a damaged chunk, or skips it; then `lost` tells between which of
        the wanted messages something is missing.
        """
        lost = LostSpans()
        self.lost = lost.found
        for batch in self._batches(topics, start, skip_damaged, lost):
            if not skip_damaged:
                yield from batch
                continue
            for message in batch:
                lost.message(message.step)
                yield message
        lost.end()

    def _batches(
        self, topics: set[str] | None, start: int, skip_damaged: bool, lost: LostSpans
    ) -> Iterator[Iterable[LogMessage]]:
        from mcap.records import Chunk, Message

        current: Path | None = None
        known = _Channels(topics)
        for path, record in self._whole_records(topics, start):
            if path != current:
                if current in self.torn:
                    lost.damage()
                current, known = path, _Channels(topics)
            if isinstance(record, Chunk):
                yield self._of_chunk(path, record.data, known, start, skip_damaged, lost)
            elif isinstance(record, Message):
                name = known.wanted.get(record.channel_id)
                if name is not None and record.log_time >= start:
                    yield [LogMessage(*name, record.log_time, record.sequence, record.data)]
            elif isinstance(record, DamagedChunk):
                self._damaged(path, skip_damaged, record.error)
                lost.damage()
            elif isinstance(record, DamagedAttachment):
                self.damaged_attachments.append(record.name)
            else:
                known.learn(record)

    def _of_chunk(
        self, path: Path, data: bytes, known: _Channels, start: int, skip: bool, lost: LostSpans
    ) -> Iterator[LogMessage]:
        from mcap.exceptions import McapError

        try:
            yield from messages_of_chunk(data, known.wanted, known.learn, start)
        except (McapError, *DAMAGE) as error:
            self._damaged(path, skip, error)
            lost.damage()

    def latest(self, topics: set[str], before: int) -> list[LogMessage]:
        """The last message of each topic before a time (ns), in the order of the log."""
        found: dict[str, LogMessage] = {}
        for path in reversed(self.files):
            if len(found) == len(topics):
                break
            here = self._latest_in(path, topics - set(found), before)
            found = here | found
        return sorted(found.values(), key=lambda message: (message.log_time, message.step))

    def _latest_in(self, path: Path, topics: set[str], before: int) -> dict[str, LogMessage]:
        from mcap.exceptions import McapError

        found: dict[str, LogMessage] = {}
        summary = self._summary(path)
        if summary is None:
            return {m.topic: m for m in self.messages(topics) if m.log_time < before}
        known = _Channels(topics)
        for definition in summary.definitions:
            known.learn(definition)
        names = {channel: name[0] for channel, name in known.wanted.items() if name is not None}
        for chunk in reversed(summary.chunks):
            here = {names[c] for c in chunk.channels & set(names)} - set(found)
            if not here or chunk.first_time >= before:
                continue
            with open(path, "rb") as file:
                content = self._chunk(file, chunk)
            if isinstance(content, DamagedChunk):
                self._damaged(path, False, content.error)
            try:
                for message in messages_of_chunk(content.data, known.wanted, known.learn):
                    if message.topic in here and message.log_time < before:
                        found[message.topic] = message
            except (McapError, *DAMAGE) as error:
                self._damaged(path, False, error)
        return found

    def attachments(self) -> dict[str, bytes]:
        """Of the first file, before its messages; the damaged ones are in `damaged_attachments`."""
        from mcap.records import Attachment

        found: dict[str, bytes] = {}
        for _, record in self._start():
            if isinstance(record, Attachment):
                found[record.name] = record.data
            elif isinstance(record, DamagedAttachment):
                self.damaged_attachments.append(record.name)
        return found

    def attachment(self, name: str, otherwise: str) -> bytes:
        """One of them. Raises RecordingError when it is damaged, or missing: `otherwise` says why
        that may be."""
        found = self.attachments()
        for damaged in self.damaged_attachments:
            if name not in found and damaged in (name, ""):
                self._damaged_attachment(self.files[0], False, damaged)
        if name in found:
            return found[name]
        if self.torn:
            raise RecordingError(f"{self.torn[0]} is empty or damaged at its start")
        if name in self.custom_data.get("damaged_attachments", "").split(", "):
            raise RecordingError(
                f"{self.directory} holds no {name}: it was damaged when the recording was recovered"
            )
        raise RecordingError(f"{self.directory} {otherwise}")

    @property
    def custom_data(self) -> dict[str, str]:
        """What the recorder noted: scene, versions, node name, ..."""
        from mcap.records import Metadata

        noted = self.metadata.get("custom_data")
        if isinstance(noted, dict) and noted:
            return {str(k): str(v) for k, v in noted.items()}
        for _, record in self._start():
            if isinstance(record, Metadata) and record.name == "rb_physics":
                return dict(record.metadata)
        return {}

    def _start(self) -> Iterator[tuple[Path, Any]]:
        """What comes before the first chunk or message."""
        from mcap.records import Chunk, Message

        for path, record in self._whole_records():
            if isinstance(record, (Chunk, DamagedChunk, Message)):
                return
            yield path, record
