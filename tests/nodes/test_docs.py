"""docs/ros.md says what the code does: every topic, service, parameter, counter and example."""

import itertools
import pkgutil
import re
from pathlib import Path

import rb_physics_nodes.examples
import sentences
from rb_physics_nodes import refused, replay_node, simulation_interfaces
from rb_physics_nodes.diagnostics import Diagnostics
from rb_physics_nodes.inputs import Inputs
from rb_physics_nodes.pacer import Pacer
from rb_physics_nodes.parameters import load_table
from rb_physics_nodes.services import BODIES, TRIGGERS
from rb_physics_nodes.simulation_interfaces import snake_case
from rb_physics_nodes.wrench_frames import WrenchFrames

import rb_physics as rb
from rb_physics.recording import Recorder
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


def test_every_error_word_for_word():
    assert sentences.written() == sentences.table(), "run python tests/nodes/sentences.py"


def test_frames_of_wrenches():
    told = [row[0].strip("` |") for row in rows("Wrenches")][1:]
    frames = WrenchFrames("NAME", (0, 0, 0), {"FRAME": ((0, 0, 0), (0, 0, 0, 1))})
    assert told == frames.frame_ids


def test_values_of_diagnostics(scene):
    world = rb.load_scene(scene).build()
    recorder = Recorder(world, None)
    inputs = Inputs(world, [], 0.1, 0.5, False, lambda key, text: None)
    diagnostics = Diagnostics(world, inputs, Pacer(1e-3, 1.0), recorder)
    told = {row[0].strip("` |"): row[1] for row in rows("Diagnostics")}
    statuses = diagnostics()
    assert set(told) == {"sim_node: physics"} | {name for _, name, *_ in statuses}
    for _, name, _, _, values in statuses:
        if name != "sim_node: log":  # whose values are the recorder's
            listed = re.sub(r"\(.*?\)", "", told[name]).split(";")[0]
            assert listed.replace(" ", "").split(",") == list(values)


def test_parameters_and_services_of_replay_node():
    source = Path(replay_node.__file__).read_text("utf-8")
    declared = set(re.findall(r'declare(?:_parameter)?\("(\w+)"', source))
    assert {row[0].strip("` |") for row in table_of("parameter of replay_node")} == declared
    services = set(re.findall(r'^            "(\w+)": ', source, flags=re.M))
    told = {n for row in table_of("service of replay_node") for n in re.findall("~/(\\w+)", row[0])}
    assert told == services


def table_of(title: str) -> list[list[str]]:
    """Cells of the rows of the table with that title of its first column."""
    lines = TEXT.split(f"| {title} |", 1)[1].splitlines()[2:]
    return [line.strip("|").split(" | ") for line in itertools.takewhile(lambda x: x, lines)]


def test_examples():
    told = {row[0].strip("` |") for row in rows("Examples")}
    modules = {module.name for module in pkgutil.iter_modules(rb_physics_nodes.examples.__path__)}
    assert told == modules - {"running"}
