"""The folder of a bag: what its metadata.yaml says, and which files belong to it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import RecordingError
from .plain_yaml import load_plain

_METADATA_LIMIT = 64 * 1024 * 1024  # bytes of metadata.yaml


def read_metadata(directory: Path) -> dict[str, Any]:
    """What metadata.yaml says about the bag; empty without one. Raises RecordingError."""
    path = directory / "metadata.yaml"
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
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise RecordingError(
            f"{path} is not the metadata of a rosbag2 bag; without it (moved away) the .mcap "
            "files are read as they are"
        )
    return information


def find_files(directory: Path, metadata: Mapping[str, Any]) -> list[Path]:
    """The .mcap files in their order, never any outside the folder. Raises RecordingError."""
    names = metadata.get("relative_file_paths")
    if names is None:
        names = [p.name for p in directory.glob("*.mcap")]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise RecordingError(f"{directory}/metadata.yaml lists no files")
    for name in names:
        if Path(name).name != name or not name.endswith(".mcap"):
            raise RecordingError(
                f"{directory}/metadata.yaml names {name!r}, which is not an .mcap file of "
                "that folder"
            )
    # A killed recorder may have begun a file that the metadata doesn't know yet.
    known = set(names) | {p.name for p in directory.glob(f"{directory.name}_*.mcap")}
    ordered = sorted(known, key=lambda name: (len(name), name))
    files = [directory / name for name in ordered]
    if not files:
        raise RecordingError(f"{directory} holds no .mcap file: it is not a recording")
    for path in files:
        if path.is_dir():
            raise RecordingError(f"{path} is a folder; it should be an MCAP file")
        if not path.is_file():
            raise RecordingError(f"{path} is missing, though metadata.yaml lists it")
    return files
