"""The launch files are valid Python, name real parameters, and load where `launch` is installed."""

import ast
import importlib.util
from pathlib import Path

import pytest
from rb_physics_nodes.parameters import load_table

from rb_physics.resources import shared_folder

FILES = sorted(shared_folder("launch").glob("*.launch.py"))


def test_there_are_launch_files():
    assert [path.name for path in FILES] == ["sim.launch.py"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_arguments_are_parameters_of_the_node_with_their_defaults(path: Path):
    tree = ast.parse(path.read_text())
    (table,) = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and node.targets[0].id == "ARGUMENTS"
    ]
    parameters = load_table()
    for key, value in zip(table.keys, table.values, strict=True):
        name, default = ast.literal_eval(key), ast.literal_eval(value.elts[0])
        expected = parameters[name]["default"]
        assert default == (str(expected).lower() if isinstance(expected, bool) else str(expected))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_files_load(path: Path):
    pytest.importorskip(
        "launch_ros", reason="launch is not among the ROS wheels; needs ROS 2 from apt"
    )
    spec = importlib.util.spec_from_file_location("launch_file", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.generate_launch_description().entities
