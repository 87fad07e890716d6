"""The launch files are valid Python, name real parameters, and load where `launch` is installed."""

import ast
import importlib.util
import runpy
import sys
import types
from pathlib import Path

import pytest
import rb_physics_nodes.replay_node
from rb_physics_nodes.parameters import load_table

from rb_physics.resources import shared_folder

FILES = sorted(shared_folder("launch").glob("*.launch.py"))


def test_there_are_launch_files():
    assert [path.name for path in FILES] == ["replay.launch.py", "sim.launch.py"]


def arguments_of(path: Path) -> dict[str, str]:
    """Names and defaults of the launch arguments, read without importing `launch`."""
    tree = ast.parse(path.read_text())
    (table,) = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and node.targets[0].id == "ARGUMENTS"
    ]
    return {
        ast.literal_eval(key): ast.literal_eval(value.elts[0])
        for key, value in zip(table.keys, table.values, strict=True)
    }


def as_text(value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def test_arguments_of_sim_are_parameters_of_the_node_with_their_defaults():
    parameters = load_table()
    for name, default in arguments_of(shared_folder("launch") / "sim.launch.py").items():
        assert default == as_text(parameters[name]["default"])


def test_arguments_of_replay_are_the_parameters_of_the_node():
    source = Path(rb_physics_nodes.replay_node.__file__).read_text()
    declared = {
        call.args[0].value: as_text(call.args[1].value)
        for call in ast.walk(ast.parse(source))
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "declare"
    }
    assert arguments_of(shared_folder("launch") / "replay.launch.py") == declared


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_files_load(path: Path):
    pytest.importorskip(
        "launch_ros", reason="launch is not among the ROS wheels; needs ROS 2 from apt"
    )
    spec = importlib.util.spec_from_file_location("launch_file", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.generate_launch_description().entities


class StandIn:
    """Takes the place of what `launch` and `launch_ros` offer; remembers how it was made."""

    def __init__(self, *positional, **keywords):
        self.positional, self.keywords = positional, keywords


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_files_describe_a_node_that_is_installed(path: Path, monkeypatch):
    """With stand-ins for `launch`, so that it is checked where ROS comes from wheels, too."""
    for module, names in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
        "launch_ros.parameter_descriptions": ["ParameterValue"],
    }.items():
        fake = types.ModuleType(module)
        for name in names:
            setattr(fake, name, type(name, (StandIn,), {}))
        monkeypatch.setitem(sys.modules, module, fake)
    *arguments, node = runpy.run_path(str(path))["generate_launch_description"]().positional[0]
    names = [argument.positional[0] for argument in arguments]
    assert names[: len(arguments_of(path))] == list(arguments_of(path))
    assert all(argument.keywords["description"] for argument in arguments)
    assert node.keywords["package"] == "rb_physics"
    setup = (Path(__file__).parents[2] / "setup.cfg").read_text()
    assert f"{node.keywords['executable']} = rb_physics_nodes." in setup
    (parameters,) = node.keywords["parameters"]
    assert list(parameters) == list(arguments_of(path))
    if path.name == "sim.launch.py":
        assert {"scene", "record_dir", "real_time_factor"} <= set(names)
        assert node.keywords["namespace"].positional == ("namespace",)
