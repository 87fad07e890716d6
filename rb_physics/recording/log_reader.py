"""Reading a recording back, finished or torn off, and never outside its folder."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import IO, Any

from .mcap_log import RecordingError
from .mcap_reader import (
    DAMAGE,
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
from .plain_yaml import load_plain

_METADATA_LIMIT = 64 * 1024 * 1024  # bytes of metadata.yaml


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
        self.metadata = self._read_metadata()
        self.files = self._find_files()
        self.torn: list[Path] = []  # files without an end; this and the next two after reading
        self.torn_bytes = 0  # behind the last whole record of those
        self.damaged_chunks = 0
        self._summaries: dict[Path, Summary | None] = {}  # of files looked into

    def _read_metadata(self) -> dict[str, Any]:
        path = self.directory / "metadata.yaml"
        try:
            if path.stat().st_size > _METADATA_LIMIT:
                raise RecordingError(f"{path} is too large to be a bag's metadata")
            content = load_plain(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except RecordingError:
            raise
        except (OSError, ValueError) as error:
            raise RecordingError(
                f"{path} can't be read: {str(error).splitlines()[0]}; without it (moved away) the "
                ".mcap files are read as they are"
            ) from None
        information = (
            content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
        )
        if not isinstance(information, dict):
            raise RecordingError(
                f"{path} is not the metadata of a rosbag2 bag; without it (moved away) the .mcap "
                "files are read as they are"
            )
        return information

    def _find_files(self) -> list[Path]:
        names = self.metadata.get("relative_file_paths")
        if names is None:
            names = [p.name for p in self.directory.glob("*.mcap")]
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise RecordingError(f"{self.directory}/metadata.yaml lists no files")
        for name in names:
            if Path(name).name != name or not name.endswith(".mcap"):
                raise RecordingError(
                    f"{self.directory}/metadata.yaml names {name!r}, which is not an .mcap file of "
                    "that folder"
                )
        # A killed recorder may have begun a file that the metadata doesn't know yet.
        known = set(names) | {p.name for p in self.directory.glob(f"{self.directory.name}_*.mcap")}
        ordered = sorted(known, key=lambda name: (len(name), name))
        files = [self.directory / name for name in ordered]
        if not files:
            raise RecordingError(f"{self.directory} holds no .mcap file: it is not a recording")
        for path in files:
            if not path.is_file():
                raise RecordingError(f"{path} is missing, though metadata.yaml lists it")
        return files

    def records(self, skip_damaged: bool = False) -> Iterator[tuple[Path, Any]]:
        """(file, MCAP record) in order, chunks taken apart; a file ends at its end or where it is
        torn (then it is in `torn`).

        Raises RecordingError for a damaged chunk, or skips and counts it in `damaged_chunks`.
        """
        from mcap.exceptions import McapError
        from mcap.records import Chunk
        from mcap.stream_reader import breakup_chunk

        for path, record in self._whole_records(skip_damaged):
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
        self, skip_damaged: bool, topics: set[str] | None = None, start: int = 0
    ) -> Iterator[tuple[Path, Any]]:
        """As `records`, with chunks uncompressed but not taken apart.

        Of finished files only the chunks with wanted messages are read, if `topics` or a `start`
        (ns) are given.
        """
        from mcap.exceptions import McapError
        from mcap.records import Chunk, Footer

        self.torn, self.torn_bytes, self.damaged_chunks = [], 0, 0
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
                                self._damaged(path, skip_damaged, error)
                                continue
                        yield path, record
            except OSError as error:
                raise RecordingError(f"{path} can't be read: {error.strerror}") from None
            except (McapError, *DAMAGE) as error:
                if isinstance(error, RecordingError):
                    raise
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
                    yield path, self._chunk(path, file, place)
                return
            # The next chunk is decompressed while this one is made use of.
            with ThreadPoolExecutor(1, "decompress") as ahead:
                coming = None
                for next_place in chain(places, [None]):
                    chunk = coming.result() if coming is not None else None
                    if next_place is not None:
                        coming = ahead.submit(self._chunk, path, file, next_place)
                    if chunk is not None:
                        yield path, chunk

    def _chunk(self, path: Path, file: IO[bytes], place: IndexedChunk) -> Any:
        from mcap.exceptions import McapError

        try:
            return decompressed(chunk_at(file, place))
        except (McapError, *DAMAGE) as error:
            self._damaged(path, False, error)

    def load_index(self) -> None:
        """Reads the index of every finished file now rather than when it is first looked into."""
        for path in self.files:
            self._summary(path)

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

    def messages(self, topics: set[str] | None = None, start: int = 0) -> Iterator[LogMessage]:
        """Every message in the order of the log; `topics` None: all; `start`: ns of log time."""
        from mcap.exceptions import McapError
        from mcap.records import Chunk, Message

        current: Path | None = None
        known = _Channels(topics)
        for path, record in self._whole_records(False, topics, start):
            if path != current:
                current, known = path, _Channels(topics)
            if isinstance(record, Chunk):
                try:
                    yield from messages_of_chunk(record.data, known.wanted, known.learn, start)
                except (McapError, *DAMAGE) as error:
                    self._damaged(path, False, error)
            elif isinstance(record, Message):
                name = known.wanted.get(record.channel_id)
                if name is not None and record.log_time >= start:
                    yield LogMessage(*name, record.log_time, record.sequence, record.data)
            else:
                known.learn(record)

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
                content = self._chunk(path, file, chunk).data
            try:
                for message in messages_of_chunk(content, known.wanted, known.learn):
                    if message.topic in here and message.log_time < before:
                        found[message.topic] = message
            except (McapError, *DAMAGE) as error:
                self._damaged(path, False, error)
        return found

    def attachments(self) -> dict[str, bytes]:
        """Of the first file, up to its first message."""
        from mcap.records import Attachment, Message

        found: dict[str, bytes] = {}
        for _, record in self.records():
            if isinstance(record, Attachment):
                found[record.name] = record.data
            elif isinstance(record, Message):
                break
        return found

    @property
    def custom_data(self) -> dict[str, str]:
        """What the recorder noted: scene, versions, node name, ..."""
        from mcap.records import Message, Metadata

        noted = self.metadata.get("custom_data")
        if isinstance(noted, dict) and noted:
            return {str(k): str(v) for k, v in noted.items()}
        for _, record in self.records():
            if isinstance(record, Metadata) and record.name == "rb_physics":
                return dict(record.metadata)
            if isinstance(record, Message):
                break
        return {}
