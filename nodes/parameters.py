"""The node's parameters: declared from msg_configs/sim.yaml, checked on every change."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

import yaml
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from rb_physics.recording.recorder_arguments import LEAST_SPLIT_BYTES
from rb_physics.resources import shared_folder

TIMEOUTS = ("wrench_timeout", "cmd_vel_timeout")
LOWEST_FACTOR = 1e-3
RCLPY_OWN = ("use_sim_time", "start_type_description_service")
TYPES = {
    "string": Parameter.Type.STRING,
    "bool": Parameter.Type.BOOL,
    "integer": Parameter.Type.INTEGER,
    "double": Parameter.Type.DOUBLE,
}


def declare(node: Node, table: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Declare every parameter of `table` (name -> entry of sim.yaml) and return their values.

    A whole number given for a double is taken as that double. Raises ValueError, in one sentence,
    for a value of the wrong type or outside its range.
    """
    check_names(node, table)
    return {name: _declare(node, name, entry) for name, entry in table.items()}


def declare_one(node: Node, name: str, default: Any) -> Any:
    """Declare a parameter of the type of its default; its value. Raises ValueError."""
    kind = {str: "string", bool: "bool", float: "double"}[type(default)]
    return _declare(node, name, {"type": kind, "default": default, "description": ""})


def check_names(node: Node, declared: Collection[str] = ()) -> None:
    """Raises ValueError for a given parameter that is neither declared yet nor one of `declared`."""
    for name in node._parameter_overrides:
        own = name in declared or name in RCLPY_OWN or name.startswith("qos_overrides.")
        if not own and not node.has_parameter(name):
            there = declared or [n for n in node._parameters if n not in RCLPY_OWN]
            raise ValueError(
                f"there is no parameter '{name}'; the parameters are {', '.join(there)}"
            )


def _declare(node: Node, name: str, entry: Mapping[str, Any]) -> Any:
    known, kind = node._parameter_overrides, TYPES[entry["type"]]
    given = known.get(name)
    if given is not None:
        if kind == Parameter.Type.DOUBLE and given.type_ == Parameter.Type.INTEGER:
            given = known[name] = Parameter(name, kind, float(given.value))
        if given.value is False and "off" in entry.get("choices", ()):
            given = known[name] = Parameter(name, kind, "off")  # what YAML makes of a bare off
        if given.type_ != kind:
            raise ValueError(f"parameter {name} is {given.value!r}, but must be a {entry['type']}")
        reason = refusal(name, entry, given.value)
        if reason is not None:
            raise ValueError(reason)
    node.declare_parameter(name, entry["default"], _descriptor(entry))
    return node.get_parameter(name).value


def check(
    table: Mapping[str, Mapping[str, Any]], parameters: list[Parameter]
) -> SetParametersResult:
    """Validation of a change at run time (a callback for add_on_set_parameters_callback)."""
    for parameter in parameters:
        entry = table.get(parameter.name)
        reason = None if entry is None else refusal(parameter.name, entry, parameter.value)
        if reason is not None:
            return SetParametersResult(successful=False, reason=reason)
    return SetParametersResult(successful=True)


def refusal(name: str, entry: Mapping[str, Any], value: Any) -> str | None:
    """Why `value` is not allowed for parameter `name`, or None."""
    choices = entry.get("choices")
    if choices is not None and value not in choices:
        return f"parameter {name} is '{value}', but must be one of {', '.join(choices)}"
    if "range" in entry:
        lowest, highest = entry["range"]
        if not math.isfinite(value) or not lowest <= value <= highest:
            return f"parameter {name} is {value}, but must lie in {lowest:g} .. {highest:g}"
    if name in TIMEOUTS and -1.0 < value < 0.0:
        return f"parameter {name} is {value}, but must be >= 0 s, or -1 for ever"
    if name == "real_time_factor" and 0.0 < value < LOWEST_FACTOR:
        return f"parameter {name} is {value}, but must be 0 or at least {LOWEST_FACTOR:g}"
    if name == "log_split_bytes" and 0 < value < LEAST_SPLIT_BYTES:
        return f"parameter {name} is {value}, but must be 0 or at least {LEAST_SPLIT_BYTES}"
    return None


def _descriptor(entry: Mapping[str, Any]) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=entry["description"], read_only=entry.get("read_only", False)
    )
    if "choices" in entry:
        descriptor.additional_constraints = f"one of {', '.join(entry['choices'])}"
    if "range" in entry:
        lowest, highest = entry["range"]
        if entry["type"] == "integer":
            descriptor.integer_range = [IntegerRange(from_value=lowest, to_value=highest, step=0)]
        else:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(lowest), to_value=float(highest), step=0.0)
            ]
    return descriptor


def load_table() -> dict[str, dict[str, Any]]:
    """The parameter table: name -> {type, default, description, range, choices, read_only}."""
    return yaml.safe_load((shared_folder("msg_configs") / "sim.yaml").read_text())
