"""The folder of a log, held open: what happens to its name leads nothing astray."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path

from .errors import FolderExistsError, RecordingError
from .rosbag2 import write_atomically


class LogFolder:
    """A folder just made. Files are made and replaced in it wherever it is moved to, and never in
    another one that has taken its name."""

    def __init__(self, path: Path) -> None:
        """Raises OSError."""
        self.path = Path(os.path.realpath(path))  # a change of the working directory moves nothing
        self._descriptor = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY)
        self._identity = os.fstat(self._descriptor)

    def create(self, name: str) -> int:
        """The descriptor of a new file, for writing. Raises OSError."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
        return os.open(name, flags, 0o644, dir_fd=self._descriptor)

    def replace(self, name: str, text: str) -> None:
        """Gives a file a new content in one step. Raises OSError."""
        write_atomically(name, text, self._descriptor)

    def holds(self, name: str, status: os.stat_result | None = None) -> bool:
        """Whether it has a file of that name; with `status`, whether it is that very file."""
        try:
            found = os.stat(name, dir_fd=self._descriptor, follow_symlinks=False)
        except FileNotFoundError:
            return False
        return status is None or os.path.samestat(found, status)

    @property
    def in_place(self) -> bool:
        """Whether its path still leads to it."""
        try:
            return os.path.samestat(os.stat(self.path), self._identity)
        except (FileNotFoundError, NotADirectoryError):
            return False

    @property
    def place(self) -> str:
        """Where it is now, as far as the system tells; empty where it doesn't."""
        try:
            found = os.readlink(f"/proc/self/fd/{self._descriptor}")
            return found if os.path.samestat(os.stat(found), self._identity) else ""
        except OSError:
            return ""

    def remove(self, names: Iterable[str]) -> None:
        """Takes the files and, when nothing else is in it, the folder away, and closes it."""
        for name in names:
            with contextlib.suppress(OSError):
                os.unlink(name, dir_fd=self._descriptor)
        if self.in_place:
            with contextlib.suppress(OSError):
                os.rmdir(self.path)
        self.close()

    def close(self) -> None:
        """Lets go of it. Safe to call again."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def make_folder(directory: Path) -> LogFolder:
    """Makes a new folder; RecordingError when it exists or can't be made."""
    try:
        if directory.parent.exists() and not directory.parent.is_dir():
            raise NotADirectoryError(None, f"{directory.parent} is a file")
        os.makedirs(directory.parent, exist_ok=True)
        os.mkdir(directory)
        return LogFolder(directory)
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


def new_run_directory(parent: str | Path) -> Path:
    """A folder name below `parent` that nothing has yet; it isn't made. Named by date and time."""
    parent = Path(parent)
    base = datetime.now().strftime("run_%Y_%m_%d-%H_%M_%S")
    path, number = parent / base, 1
    while path.exists():
        number += 1
        path = parent / f"{base}_{number}"
    return path
