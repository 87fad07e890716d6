"""A whole bag from a recording that was torn off or damaged; the original is never touched."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from .definitions import UnknownTypeError
from .errors import RecordingError
from .log_reader import Recording
from .lost_spans import LostSpan, LostSpans
from .lost_spans import from_json as lost_from_json
from .lost_spans import to_json as lost_to_json
from .mcap_log import Attachment
from .mcap_reader import read_summary
from .plain_yaml import load_plain
from .rosbag2 import FileInfo, bag_metadata, write_atomically
from .topics import Qos


class Recovered(NamedTuple):
    """What `recover` saved."""

    directory: Path
    messages: int
    until: float  # s of log time, of the last message
    torn_bytes: int  # behind the last whole record
    damaged_chunks: int  # left out
    damaged_attachments: tuple[str, ...] = ()  # names; left out


def _records(log: Recording) -> Iterator[tuple[Path, Any]]:
    """All that can be read; of finished files first what the channels are, as their end repeats it:
    the chunk that says it may be damaged."""
    current: Path | None = None
    for path, record in log.records(skip_damaged=True):
        if path != current:
            current = path
            with open(path, "rb") as file:
                summary = read_summary(file)
            for definition in summary.definitions if summary is not None else ():
                yield path, definition
        yield path, record


def recover(recording: str | Path) -> Recovered:
    """Copies every whole message of DIR into DIR_recovered. Raises RecordingError."""
    log = Recording(recording)
    source = log.directory.resolve()
    target = source.with_name(source.name + "_recovered")
    if target.exists():
        raise RecordingError(
            f"{target} exists already and is never overwritten: move it away first"
        )
    try:
        target.mkdir()
    except OSError as error:
        raise RecordingError(
            f"{target} can't be made ({error.strerror}): copy {source.name} to where you may write"
        ) from None
    try:
        return _copy(log, source, target)
    except OSError as error:
        shutil.rmtree(target, ignore_errors=True)  # its own, and not whole
        raise RecordingError(
            f"{target} can't be written ({error.strerror}): copy {source.name} to where there is room"
        ) from None


def _copy(log: Recording, source: Path, target: Path) -> Recovered:
    from mcap.records import Attachment as AttachmentRecord
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.writer import CompressionType, Writer

    info = FileInfo(f"{target.name}_0.mcap")
    topics: dict[int, Any] = {}  # channel in the copy -> its record
    counts: dict[int, int] = {}
    types: dict[int, str] = {}
    custom: dict[str, str] = {}
    closing: dict[str, str] = {}  # of all files
    lost, lost_before = LostSpans(), list[LostSpan]()
    seen = (0, 0)  # damaged chunks and torn files so far
    with open(target / info.path, "xb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="rb_physics recover")
        current: Path | None = None
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        known_schemas: dict[tuple[str, bytes], int] = {}
        known_channels: dict[tuple[str, int], int] = {}
        attached: set[str] = set()
        for path, record in _records(log):
            if path != current:
                current, schemas, channels = path, {}, {}
            if seen != (seen := (log.damaged_chunks, len(log.torn))):
                lost.damage()
            if isinstance(record, Schema):
                key = (record.name, record.data)
                if key not in known_schemas:
                    known_schemas[key] = writer.register_schema(
                        record.name, record.encoding, record.data
                    )
                    types[known_schemas[key]] = record.name
                schemas[record.id] = known_schemas[key]
            elif isinstance(record, Channel) and record.schema_id in schemas:
                schema = schemas[record.schema_id]
                name = (record.topic, schema)
                if name not in known_channels:
                    channel = writer.register_channel(
                        record.topic, record.message_encoding, schema, record.metadata
                    )
                    known_channels[name] = channel
                    topics[channel], counts[channel] = (record, types[schema]), 0
                channels[record.id] = known_channels[name]
            elif isinstance(record, Message) and record.channel_id in channels:
                channel = channels[record.channel_id]
                lost.message(record.sequence)
                writer.add_message(
                    channel, record.log_time, record.data, record.publish_time, record.sequence
                )
                counts[channel] += 1
                info.start = record.log_time if info.start is None else info.start
                info.end = max(info.end, record.log_time)
                info.message_count += 1
            elif isinstance(record, AttachmentRecord) and record.name not in attached:
                attached.add(record.name)
                writer.add_attachment(
                    record.create_time, record.log_time,
                    *Attachment(record.name, record.media_type, record.data),
                )  # fmt: skip
            elif isinstance(record, Metadata) and record.name == "rb_physics_closing":
                closing |= record.metadata
            elif isinstance(record, Metadata) and record.name == "rb_physics_recovered":
                lost_before += lost_from_json(record.metadata.get("lost_steps", "[]"))
            elif isinstance(record, Metadata) and record.name not in attached:
                attached.add(record.name)
                writer.add_metadata(record.name, record.metadata)
                if record.name == "rb_physics":
                    custom = dict(record.metadata)
        if seen != (log.damaged_chunks, len(log.torn)):
            lost.damage()
        lost.end()
        missing = tuple(n for n in dict.fromkeys(log.damaged_attachments) if n not in attached)
        if closing:
            writer.add_metadata("rb_physics_closing", closing)
        custom |= closing
        custom |= {
            "recovered_from": source.name,
            "torn_bytes": str(log.torn_bytes),
            "damaged_chunks": str(log.damaged_chunks),
            "damaged_attachments": ", ".join(missing),
            "lost_steps": lost_to_json([*lost_before, *lost.found]),
        }
        writer.add_metadata("rb_physics_recovered", custom)
        writer.finish()
    if info.message_count == 0:
        (target / info.path).unlink()
        target.rmdir()
        raise RecordingError(f"{source} holds no whole message: there is nothing to recover")
    listed = [
        (record.topic, type_name, _qos(record.metadata), counts[channel])
        for channel, (record, type_name) in topics.items()
    ]
    try:
        text = bag_metadata([info], listed, custom)
    except UnknownTypeError as error:  # a message type that isn't installed here
        raise RecordingError(f"{target} holds all messages but no metadata.yaml: {error}") from None
    write_atomically(target / "metadata.yaml", text)
    return Recovered(
        target, info.message_count, info.end * 1e-9, log.torn_bytes, log.damaged_chunks, missing
    )


def _qos(metadata: dict[str, str]) -> Qos:
    """The QoS noted with a channel, as far as it can be read."""
    try:
        [offered] = load_plain(metadata["offered_qos_profiles"])
        return Qos(offered["reliability"], offered["durability"], offered["history"],
                   int(offered["depth"]))  # fmt: skip
    except (KeyError, TypeError, ValueError):
        return Qos()
