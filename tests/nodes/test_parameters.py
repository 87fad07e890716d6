"""sim.yaml is complete and its rules hold."""

import math

import pytest
from rb_physics_nodes.parameters import TYPES, load_table, refusal

TABLE = load_table()
PYTHON = {"string": str, "bool": bool, "integer": int, "double": float}


@pytest.mark.parametrize("name", TABLE)
def test_entries_are_complete_and_their_defaults_allowed(name):
    entry = TABLE[name]
    assert set(entry) <= {"type", "default", "range", "choices", "read_only", "description"}
    assert entry["type"] in TYPES
    assert type(entry["default"]) is PYTHON[entry["type"]]
    assert entry["description"].endswith(".")
    assert refusal(name, entry, entry["default"]) is None


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("real_time_factor", -1.0, "must lie in 0 .. 1000"),
        ("real_time_factor", math.nan, "must lie in"),
        ("real_time_factor", 1e-9, "must be 0 or at least 0.001"),
        ("log_split_bytes", 1, "must be 0 or at least 10000"),
        ("wrench_timeout", -0.5, "must be >= 0 s, or -1 for ever"),
        ("wrench_timeout", -2.0, "must lie in -1"),
        ("wrench_timeout", math.inf, "must lie in"),
        ("rerun", "on", "must be one of off, file, live"),
        ("step_count", 0, "must lie in 1"),
        ("clock_rate", 0.0, "must lie in 0.1"),
    ],
)
def test_values_out_of_range_are_refused_by_name_and_value(name, value, words):
    reason = refusal(name, TABLE[name], value)
    assert reason is not None
    assert reason.startswith(f"parameter {name} is ")
    assert words in reason
