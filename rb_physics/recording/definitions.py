"""Message definitions and type hashes that a bag needs, without ROS installed.

`definitions.json` holds every type the simulator writes: its fields (comments stripped) and its
RIHS01 hash. Other types are looked up among the installed message packages. Make the table anew
with ``python -m rb_physics.recording.definitions`` where the ROS message packages are installed.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

_TABLE = Path(__file__).with_name("definitions.json")
_WRITTEN = (
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/PoseArray",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/WrenchStamped",
    "nav_msgs/msg/Odometry",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/MultiDOFJointState",
    "sensor_msgs/msg/PointCloud2",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/String",
    "std_msgs/msg/UInt64MultiArray",
    "std_msgs/msg/UInt8MultiArray",
    "tf2_msgs/msg/TFMessage",
    "visualization_msgs/msg/MarkerArray",
)
_TF_MESSAGE = "tf2_msgs/msg/TFMessage"  # its package is not always installed: one field, known
_INTEGERS = tuple(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
_PRIMITIVES = {"bool", "byte", "char", "string", "wstring", "float32", "float64", *_INTEGERS}


class UnknownTypeError(LookupError, ValueError):
    """A message type that is neither in the shipped table nor installed; says what to install."""


class Definition(NamedTuple):
    """What a bag says of a message type."""

    text: str  # the .msg text followed by those of its dependencies
    type_hash: str  # RIHS01_...


@functools.cache
def _table() -> dict[str, dict[str, str]]:
    table: dict[str, dict[str, str]] = json.loads(_TABLE.read_text(encoding="utf-8"))
    return table


@functools.cache
def definition(type_name: str) -> Definition:
    """The definition of e.g. ``geometry_msgs/msg/PoseArray``.

    Raises UnknownTypeError when the type is neither in the shipped table nor installed.
    """
    table = _table()

    def fields(name: str) -> str:
        return table[name]["fields"] if name in table else installed_fields(name)

    type_hash = table[type_name]["hash"] if type_name in table else installed_hash(type_name)
    parts = [fields(type_name)]
    for name in _dependencies(type_name, fields):
        package, _, short = name.split("/")
        parts.append(f"{'=' * 80}\nMSG: {package}/{short}\n{fields(name)}")
    return Definition("\n".join(parts), type_hash)


def _share_folders() -> list[Path]:
    prefixes = [p for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    return [Path(p) / "share" for p in (*prefixes, sys.prefix)]


def _installed_file(type_name: str, suffix: str) -> Path:
    parts = type_name.split("/")
    if len(parts) != 3 or parts[1] != "msg":
        raise UnknownTypeError(f"{type_name!r} is not a message type such as std_msgs/msg/String")
    for share in _share_folders():
        path = share / parts[0] / "msg" / (parts[2] + suffix)
        if path.is_file():
            return path
    raise UnknownTypeError(
        f"message type {type_name} is not known: install its package or source the workspace that "
        "has it"
    )


def installed_fields(type_name: str) -> str:
    """Field and constant lines of an installed .msg file, without comments and blank lines."""
    if type_name == _TF_MESSAGE:
        return "geometry_msgs/TransformStamped[] transforms\n"
    lines = _installed_file(type_name, ".msg").read_text(encoding="utf-8").splitlines()
    kept = (" ".join(line.split("#")[0].split()) for line in lines)
    return "".join(line + "\n" for line in kept if line)


def installed_hash(type_name: str) -> str:
    """RIHS01 hash of an installed type."""
    if type_name == _TF_MESSAGE:
        return _tf_message_hash()
    described = json.loads(_installed_file(type_name, ".json").read_text(encoding="utf-8"))
    for entry in described["type_hashes"]:
        if entry["type_name"] == type_name:
            return str(entry["hash_string"])
    raise UnknownTypeError(f"the installed description of {type_name} holds no hash of it")


def _dependencies(type_name: str, fields: Callable[[str], str]) -> list[str]:
    """Every type that `type_name` refers to, directly or not, sorted."""
    found: set[str] = set()
    todo = [type_name]
    while todo:
        name = todo.pop()
        for line in fields(name).splitlines():
            kind = line.split()[0].split("[")[0].split("<")[0]
            if kind in _PRIMITIVES or "=" in line.split()[1]:
                continue
            package, _, short = kind.rpartition("/")
            full = f"{package or name.split('/')[0]}/msg/{short}"
            if kind == "Header":
                full = "std_msgs/msg/Header"
            if full not in found:
                found.add(full)
                todo.append(full)
    return sorted(found)


def type_description_hash(description: dict) -> str:
    """RIHS01 of a type description (REP 2016): SHA-256 of its JSON without default values."""

    def hashable(individual: dict) -> dict:
        return {
            "type_name": individual["type_name"],
            "fields": [{"name": f["name"], "type": f["type"]} for f in individual["fields"]],
        }

    canonical = json.dumps(
        {
            "type_description": hashable(description["type_description"]),
            "referenced_type_descriptions": [
                hashable(d) for d in description["referenced_type_descriptions"]
            ],
        },
        ensure_ascii=True,
        sort_keys=False,
    )
    return "RIHS01_" + hashlib.sha256(canonical.encode()).hexdigest()


def _tf_message_hash() -> str:
    element = "geometry_msgs/msg/TransformStamped"
    described = json.loads(_installed_file(element, ".json").read_text(encoding="utf-8"))
    inner = described["type_description_msg"]
    field = {
        "name": "transforms",
        "type": {
            "type_id": 145,  # unbounded sequence of a nested type
            "capacity": 0,
            "string_capacity": 0,
            "nested_type_name": element,
        },
    }
    referenced = [inner["type_description"], *inner["referenced_type_descriptions"]]
    return type_description_hash(
        {
            "type_description": {"type_name": _TF_MESSAGE, "fields": [field]},
            "referenced_type_descriptions": sorted(referenced, key=lambda d: d["type_name"]),
        }
    )


def make_table() -> dict[str, dict[str, str]]:
    """The shipped table, from the installed message packages."""
    names = set(_WRITTEN)
    for name in _WRITTEN:
        names.update(_dependencies(name, installed_fields))
    return {n: {"hash": installed_hash(n), "fields": installed_fields(n)} for n in sorted(names)}


if __name__ == "__main__":
    _TABLE.write_text(json.dumps(make_table(), indent=1) + "\n", encoding="utf-8")
