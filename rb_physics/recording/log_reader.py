"""Reading a recording back, finished or torn off, and never outside its folder."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple

import yaml

from .mcap_log import RecordingError

_RECORD_LIMIT = 256 * 1024 * 1024  # bytes one record of a file may claim
_MAGIC = b"\x89MCAP0\r\n"
_RECORD_HEAD = struct.Struct("<BQ")  # of the MCAP specification: opcode, length
_MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, sequence, log_time, publish_time
_DAMAGE = (ValueError, struct.error)  # what damaged bytes lead to, beside mcap's own McapError
_METADATA_LIMIT = 64 * 1024 * 1024  # bytes of metadata.yaml


def _top_level_records(file: IO[bytes]) -> Iterator[Any]:
    """The records that matter here; indexes are passed over unread, which is most of the work.

    Ends behind the footer. Raises ValueError, struct.error or McapError where the file is torn or
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
    while True:
        opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
        if length > min(_RECORD_LIMIT, size - file.tell()):
            raise ValueError(f"a record claims {length} bytes")
        if opcode == Opcode.MESSAGE:
            stream = ReadDataStream(BytesIO(file.read(length)))
            yield records.Message.read(stream, length)
        elif opcode in kinds:
            yield kinds[opcode].read(ReadDataStream(BytesIO(file.read(length))))
            if opcode == Opcode.FOOTER:
                return
        else:
            file.seek(length, os.SEEK_CUR)


def _decompressed(chunk: Any) -> Any:
    """The chunk with its data uncompressed, never more than it announces. Raises ValueError."""
    size, data = chunk.uncompressed_size, chunk.data
    if size > _RECORD_LIMIT:
        raise ValueError(f"it claims {size} bytes")
    if chunk.compression == "zstd":
        import zstandard

        try:
            with zstandard.ZstdDecompressor(max_window_size=2**27).stream_reader(data) as reader:
                data = reader.read(size + 1)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None
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


class LogMessage(NamedTuple):
    """One message of a recording."""

    topic: str
    type: str
    log_time: int  # ns
    step: int  # as the recorder wrote it
    data: bytes


def _messages_of_chunk(
    data: bytes, channels: dict[int, tuple[str, str] | None], learn: Callable[[Any], None]
) -> Iterator[LogMessage]:
    """The wanted messages; the others are passed over without making objects of them."""
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Schema

    position, end = 0, len(data)
    while position < end:
        opcode, length = _RECORD_HEAD.unpack_from(data, position)
        start = position + _RECORD_HEAD.size
        position = start + length
        if position > end:
            raise ValueError("a record is longer than its chunk")
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, _ = _MESSAGE_HEAD.unpack_from(data, start)
            known = channels.get(channel)
            if known is not None:
                content = data[start + _MESSAGE_HEAD.size : position]
                yield LogMessage(*known, log_time, sequence, content)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            stream = ReadDataStream(BytesIO(data[start:position]))
            learn((Schema if opcode == Opcode.SCHEMA else Channel).read(stream))


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

    def _read_metadata(self) -> dict[str, Any]:
        path = self.directory / "metadata.yaml"
        try:
            if path.stat().st_size > _METADATA_LIMIT:
                raise RecordingError(f"{path} is too large to be a bag's metadata")
            loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the fast one where it is built
            content = yaml.load(path.read_text(encoding="utf-8"), Loader=loader)
        except FileNotFoundError:
            return {}
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise RecordingError(f"{path} can't be read: {str(error).splitlines()[0]}") from None
        information = (
            content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
        )
        if not isinstance(information, dict):
            raise RecordingError(f"{path} is not the metadata of a rosbag2 bag")
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
                parts = breakup_chunk(record)
            except (McapError, *_DAMAGE) as error:
                self._damaged(path, skip_damaged, error)
                continue
            for part in parts:
                yield path, part

    def _whole_records(self, skip_damaged: bool) -> Iterator[tuple[Path, Any]]:
        """As `records`, with chunks as uncompressed but not taken apart."""
        from mcap.exceptions import McapError
        from mcap.records import Chunk, Footer

        self.torn, self.torn_bytes, self.damaged_chunks = [], 0, 0
        for path in self.files:
            complete, good = False, 0
            try:
                with open(path, "rb") as file:
                    for record in _top_level_records(file):
                        good = file.tell()
                        complete = isinstance(record, Footer)
                        if isinstance(record, Chunk):
                            try:
                                record = _decompressed(record)
                            except _DAMAGE as error:
                                self._damaged(path, skip_damaged, error)
                                continue
                        yield path, record
            except OSError as error:
                raise RecordingError(f"{path} can't be read: {error.strerror}") from None
            except (McapError, *_DAMAGE) as error:
                if isinstance(error, RecordingError):
                    raise
                complete = False
            if not complete:
                self.torn.append(path)
                self.torn_bytes += path.stat().st_size - good

    def _damaged(self, path: Path, skip: bool, error: Exception) -> None:
        if not skip:
            raise RecordingError(
                f"a chunk of {path} is damaged ({error}): `rb_physics recover {self.directory}` "
                "keeps the rest"
            )
        self.damaged_chunks += 1

    def messages(self, topics: set[str] | None = None) -> Iterator[LogMessage]:
        """Every message in the order of the log; `topics` None: all."""
        from mcap.exceptions import McapError
        from mcap.records import Channel, Chunk, Message, Schema

        current: Path | None = None
        schemas: dict[int, str] = {}
        channels: dict[int, tuple[str, str] | None] = {}

        def learn(record: Any) -> None:
            if isinstance(record, Schema):
                schemas[record.id] = record.name
            elif isinstance(record, Channel):
                wanted = topics is None or record.topic in topics
                name = schemas.get(record.schema_id, "")
                channels[record.id] = (record.topic, name) if wanted else None

        for path, record in self._whole_records(False):
            if path != current:
                current = path
                schemas.clear()
                channels.clear()
            if isinstance(record, Chunk):
                try:
                    yield from _messages_of_chunk(record.data, channels, learn)
                except (McapError, *_DAMAGE) as error:
                    self._damaged(path, False, error)
            elif isinstance(record, Message):
                known = channels.get(record.channel_id)
                if known is not None:
                    yield LogMessage(*known, record.log_time, record.sequence, record.data)
            else:
                learn(record)

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
