"""Reading a recording back, finished or torn off, and never outside its folder."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO, Any, NamedTuple, cast

import yaml

from .mcap_log import RecordingError

_RECORD_LIMIT = 256 * 1024 * 1024  # bytes one record of a file may claim
_METADATA_LIMIT = 64 * 1024 * 1024  # bytes of metadata.yaml


class _Bounded:
    """A file whose damaged lengths can't ask for more memory than the file is long."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._size = os.fstat(file.fileno()).st_size

    def read(self, size: int = -1) -> bytes:
        left = self._size - self._file.tell()
        return self._file.read(left if size < 0 else min(size, left))


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
            content = yaml.safe_load(path.read_text(encoding="utf-8"))
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
        from mcap.records import Chunk, Footer
        from mcap.stream_reader import StreamReader, breakup_chunk

        self.torn, self.torn_bytes, self.damaged_chunks = [], 0, 0
        for path in self.files:
            complete, good = False, 0
            try:
                with open(path, "rb") as file:
                    reader = StreamReader(
                        cast(IO[bytes], _Bounded(file)),
                        emit_chunks=True,
                        record_size_limit=_RECORD_LIMIT,
                    )
                    for record in reader.records:
                        good = file.tell()
                        complete = isinstance(record, Footer)
                        if not isinstance(record, Chunk):
                            yield path, record
                            continue
                        try:
                            parts = breakup_chunk(_decompressed(record), validate_crc=False)
                        except (McapError, ValueError, struct.error, UnicodeDecodeError) as error:
                            self._damaged(path, good, skip_damaged, error)
                            continue
                        for part in parts:
                            yield path, part
            except OSError as error:
                raise RecordingError(f"{path} can't be read: {error.strerror}") from None
            except (McapError, ValueError, struct.error, UnicodeDecodeError) as error:
                if isinstance(error, RecordingError):
                    raise
                complete = False
            if not complete:
                self.torn.append(path)
                self.torn_bytes += path.stat().st_size - good

    def _damaged(self, path: Path, end: int, skip: bool, error: Exception) -> None:
        if not skip:
            raise RecordingError(
                f"{path} is damaged in the chunk before byte {end} ({error}): "
                f"`rb_physics recover {self.directory}` keeps the rest"
            )
        self.damaged_chunks += 1

    def messages(self, topics: set[str] | None = None) -> Iterator[LogMessage]:
        """Every message in the order of the log; `topics` None: all."""
        from mcap.records import Channel, Message, Schema

        current: Path | None = None
        schemas: dict[int, str] = {}
        channels: dict[int, tuple[str, str] | None] = {}
        for path, record in self.records():
            if path != current:
                current, schemas, channels = path, {}, {}
            if isinstance(record, Message):
                known = channels.get(record.channel_id)
                if known is not None:
                    yield LogMessage(*known, record.log_time, record.sequence, record.data)
            elif isinstance(record, Channel):
                wanted = topics is None or record.topic in topics
                name = schemas.get(record.schema_id, "")
                channels[record.id] = (record.topic, name) if wanted else None
            elif isinstance(record, Schema):
                schemas[record.id] = record.name

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
