"""What recordings raise."""

from __future__ import annotations


class RecordingError(ValueError):
    """A recording that can't be made or read; one sentence that says what to do."""


class FolderExistsError(RecordingError):
    """The folder of a recording exists already."""
