"""What makes MCAP files a bag that rosbag2 (Jazzy) opens: schemas, channels, metadata.yaml."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml

from .definitions import definition
from .topics import Qos

METADATA_VERSION = 9
ROS_DISTRO = "jazzy"
_FOREVER = {"sec": 9223372036, "nsec": 854775807}  # how rosbag2 spells an infinite duration


@dataclass
class FileInfo:
    """One .mcap file of a bag. Times in ns of log time."""

    path: str
    start: int | None = None
    end: int = 0
    message_count: int = 0
    size: int = 0  # bytes


def qos_profiles(qos: Qos) -> list[dict]:
    """The offered QoS in rosbag2's textual form."""
    return [
        {
            "history": qos.history,
            "depth": qos.depth,
            "reliability": qos.reliability,
            "durability": qos.durability,
            "deadline": dict(_FOREVER),
            "lifespan": dict(_FOREVER),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(_FOREVER),
            "avoid_ros_namespace_conventions": False,
        }
    ]


def channel_metadata(type_name: str, qos: Qos) -> dict[str, str]:
    """The two keys rosbag2 writes with every channel."""
    return {
        "offered_qos_profiles": _qos_text(qos),
        "topic_type_hash": definition(type_name).type_hash,
    }


@cache
def _qos_text(qos: Qos) -> str:
    return yaml.safe_dump(qos_profiles(qos), sort_keys=False)


def bag_metadata(
    files: Sequence[FileInfo],
    topics: Sequence[tuple[str, str, Qos, int]],
    custom_data: Mapping[str, str],
) -> str:
    """Text of metadata.yaml; topics are (name, type, qos, message count)."""
    started = [f.start for f in files if f.start is not None]
    start = min(started, default=0)
    end = max((f.end for f in files if f.start is not None), default=start)

    def since(time_ns: int | None) -> dict[str, int]:
        return {"nanoseconds_since_epoch": time_ns if time_ns is not None else 0}

    information = {
        "version": METADATA_VERSION,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": end - start},
        "starting_time": since(start),
        "message_count": sum(f.message_count for f in files),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": name,
                    "type": type_name,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": qos_profiles(qos),
                    "type_description_hash": definition(type_name).type_hash,
                },
                "message_count": count,
            }
            for name, type_name, qos, count in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [f.path for f in files],
        "files": [
            {
                "path": f.path,
                "starting_time": since(f.start),
                "duration": {"nanoseconds": f.end - f.start if f.start is not None else 0},
                "message_count": f.message_count,
            }
            for f in files
        ],
        "custom_data": dict(custom_data),
        "ros_distro": ROS_DISTRO,
    }
    return yaml.dump(
        {"rosbag2_bagfile_information": information}, Dumper=_PlainDumper, sort_keys=False
    )


class _PlainDumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """Without anchors and aliases: rosbag2's reader should see plain values."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def write_atomically(path: str | Path, text: str, folder: int | None = None) -> None:
    """Replaces a file in one step: a reader sees the old text or the new one, never a part.

    `folder`: the descriptor of the one that `path` is in; None: of the working directory. Raises
    OSError, and leaves nothing but the old text then.
    """
    temporary = f"{path}.tmp"

    def create(name: str, flags: int) -> int:
        return os.open(name, flags, 0o644, dir_fd=folder)

    try:
        with open(temporary, "w", encoding="utf-8", opener=create) as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path, src_dir_fd=folder, dst_dir_fd=folder)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary, dir_fd=folder)
        raise
