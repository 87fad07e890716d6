"""docs/ros.md says what the code does: every topic, service, parameter, counter and example."""

import pkgutil
import re
from pathlib import Path

import rb_physics_nodes.examples
from rb_physics_nodes import refused, simulation_interfaces
from rb_physics_nodes.parameters import load_table
from rb_physics_nodes.services import BODIES, TRIGGERS
from rb_physics_nodes.simulation_interfaces import snake_case

from rb_physics.recording.topics import load_topics

TEXT = (Path(__file__).parents[2] / "docs" / "ros.md").read_text("utf-8")
# The node's own echo, and what topics.yaml shows as a comment.
NOT_IN_TABLE = {"~/operations", "~/bodies/NAME/wrench/SOURCE"}


def rows(heading: str) -> list[list[str]]:
    """Cells of the table rows below a heading."""
    section = re.split(r"^#+ ", TEXT.split(f" {heading}\n", 1)[1], maxsplit=1, flags=re.M)[0]
    lines = [line for line in section.splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_topics():
    entries = load_topics().entries
    for heading, direction in (("Sent", "out"), ("Taken", "in")):
        told = {row[0].strip("` |"): row[1] for row in rows(heading)}
        known = {entry.name: entry.type for entry in entries if entry.direction == direction}
        assert {name: kind for name, kind in told.items() if name not in NOT_IN_TABLE} == known


def test_services():
    told = {
        name.removeprefix("~/")
        for row in rows("Services")
        for name in re.findall("`([^`]*)`", row[0])
    }
    standard = [*simulation_interfaces.SERVICES, *simulation_interfaces.ACTIONS]
    assert told == {"pause", "step", *TRIGGERS, *BODIES} | {snake_case(name) for name in standard}


def test_parameters():
    told = {row[0].strip("` |"): row for row in rows("Parameters")}
    table = load_table()
    assert list(told) == list(table)
    for name, entry in table.items():
        default = entry["default"]
        default = str(default).lower() if isinstance(default, bool) else str(default)
        kind, given, allowed, fixed, meaning = told[name][1:]
        assert (kind, given) == (entry["type"], default)
        assert (fixed == "yes") == entry.get("read_only", False)
        assert meaning.rstrip("| ") == entry["description"]
        if "range" in entry:
            assert allowed == "{:g} .. {:g}".format(*entry["range"])
        if "choices" in entry:
            assert allowed == ", ".join(entry["choices"])


def test_refusals_are_told_by_their_counters():
    kinds = [k for k in vars(refused).values() if isinstance(k, type)]
    assert len(kinds) == 6
    for kind in kinds:
        assert kind.counter in TEXT


def test_examples():
    told = {row[0].strip("` |") for row in rows("Examples")}
    modules = {module.name for module in pkgutil.iter_modules(rb_physics_nodes.examples.__path__)}
    assert told == modules - {"running"}
