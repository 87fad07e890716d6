"""Where results for people go: new files and folders, nothing is ever overwritten."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import RecordingError


def new_file(path: str | Path) -> Path:
    """A path that nothing has yet, in a folder that is there. Raises RecordingError."""
    path = Path(path)
    if path.exists():
        raise RecordingError(f"{path} exists already and is never overwritten")
    if not path.parent.is_dir():
        what = (
            "is a file, not a folder" if path.parent.exists() else "does not exist: make it first"
        )
        raise RecordingError(f"{path} can't be written: the folder {path.parent} {what}")
    return path


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turns what the disk refuses into one RecordingError."""
    try:
        yield
    except OSError as error:
        raise RecordingError(
            f"{path} can't be written ({error.strerror or error}): choose a place that you may write "
            "to and that has room"
        ) from None
