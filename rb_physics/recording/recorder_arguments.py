"""What a recorder is given, checked before anything is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any

from .. import checks
from ..errors import SceneError
from ..scene import Scene
from ..world import World
from .errors import RecordingError
from .mcap_log import COMPRESSIONS
from .message_queue import POLICIES
from .topics import TopicTable

LEAST_SPLIT_BYTES = 10_000  # below it what begins and ends a file is more than what it holds


def checked(
    world: Any,
    directory: Any,
    scene: Any,
    topics: Any,
    node_name: Any,
    rerun: Any,
    snapshot_interval: Any,
    custom_data: Any,
    initial: Any = None,
    first: Any = (),
    log_start: Any = None,
    held_wrenches: Any = None,
) -> float:
    """The interval, once all arguments are of the right kind. Raises RecordingError."""
    notes = {} if custom_data is None else custom_data
    try:
        for name, value, good, allowed in (
            ("world", world, isinstance(world, World), "an rb.World"),
            ("directory", directory, directory is None or isinstance(directory, (str, PathLike)),
             "the path of a new folder, or None"),
            ("scene", scene, scene is None or isinstance(scene, Scene),
             "the rb.Scene that the world was built from, or None"),
            ("topics", topics, topics is None or isinstance(topics, TopicTable),
             "what load_topics(path) returns, or None"),
            ("node_name", node_name, isinstance(node_name, str) and node_name.strip("/") != "",
             "the name of a node, such as sim_node"),
            ("rerun", rerun, isinstance(rerun, str) and rerun in ("off", "file", "live"),
             "off, file or live"),
            ("custom_data", custom_data, isinstance(notes, Mapping)
             and all(isinstance(text, str) for pair in notes.items() for text in pair),
             "a dict of texts, or None"),
            ("initial", initial, initial is None or isinstance(initial, bytes),
             "what world.save() returned, or None"),
            ("first", first, _are_operations(first),
             "a list of pairs (name of an operation, dict of its arguments)"),
            ("held_wrenches", held_wrenches, held_wrenches is None or isinstance(held_wrenches, str),
             "what HeldWrenches.to_json returns, or None"),
        ):  # fmt: skip
            if not good:
                raise SceneError.about(None, name, value, allowed)
        if log_start is not None:
            checks.whole_number("log_start", log_start, 0, 2**62)
        return checks.number(
            None, "snapshot_interval", snapshot_interval, 0.0, above=True, unit="s"
        )
    except SceneError as error:
        raise RecordingError(str(error)) from None


def _are_operations(first: Any) -> bool:
    return isinstance(first, Sequence) and all(
        isinstance(pair, (tuple, list))
        and len(pair) == 2
        and isinstance(pair[0], str)
        and isinstance(pair[1], Mapping)
        for pair in first
    )


def check_log_options(options: Mapping[str, Any]) -> None:
    """The options of `McapLog` among the keywords of a recorder. Raises RecordingError."""
    unknown = [name for name in options if name not in _LOG_OPTIONS]
    if unknown:
        raise RecordingError(
            f"unknown option {unknown[0]!r}{checks.suggestion(unknown[0], _LOG_OPTIONS)}"
        )
    try:
        for name, value in options.items():
            if value is not None or not name.startswith("split_"):
                _LOG_OPTIONS[name](name, value)
    except SceneError as error:
        raise RecordingError(str(error)) from None


def _bytes(name: str, value: Any) -> None:
    checks.whole_number(name, value, 1, 2**62)


def _seconds(name: str, value: Any) -> None:
    checks.number(None, name, value, 0.0, above=True, unit="s")


_LOG_OPTIONS: dict[str, Callable[[str, Any], object]] = {
    "compression": lambda name, value: checks.choice(None, name, value, COMPRESSIONS),
    "chunk_bytes": _bytes,
    "flush_interval": _seconds,
    "queue_bytes": _bytes,
    "policy": lambda name, value: checks.choice(None, name, value, POLICIES),
    "split_bytes": lambda name, value: checks.whole_number(name, value, LEAST_SPLIT_BYTES, 2**62),
    "split_duration": _seconds,
    "fsync": checks.flag,
}
