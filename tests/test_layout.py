"""The house rules that a reader relies on: who may use whom, and that the map is true."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
CORE = ROOT / "rb_physics" / "core"
STAGES = ["math", "body", "shape", "collision", "contact", "solver", "island", "world", "bindings"]
SIBLINGS = {("body", "shape"), ("shape", "body")}  # the same stage
CPP = sorted(path for end in ("*.hpp", "*.cpp") for path in CORE.rglob(end))

if not (ROOT / "package.xml").is_file():
    pytest.skip("needs the source tree", allow_module_level=True)


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def code_of(path: Path) -> str:
    """Source without comments and text literals."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", path.read_text("utf-8"), flags=re.S)
    return re.sub(r'(?<!include )"(\\.|[^"\\\n])*"', '""', text)


@pytest.mark.parametrize("path", CPP, ids=relative)
def test_core_file_includes_only_its_own_or_earlier_stages(path: Path) -> None:
    stage = path.relative_to(CORE).parts[0]
    assert stage in STAGES
    for header in re.findall(r'#include "([^"]+)"', path.read_text("utf-8")):
        assert (CORE / header).is_file(), f"{header} is not relative to rb_physics/core"
        other = header.split("/")[0]
        assert STAGES.index(other) <= STAGES.index(stage), f"{stage} must not know {other}"
        assert (stage, other) not in SIBLINGS, f"{stage} must not know {other}"


@pytest.mark.parametrize("path", CPP, ids=relative)
def test_core_file_keeps_the_build_and_determinism_rules(path: Path) -> None:
    code = code_of(path)
    stage = path.relative_to(CORE).parts[0]
    if stage != "bindings":
        assert not re.search(r"pybind11|Python\.h", code), "Python is known in bindings/ only"
    if path.suffix == ".hpp":
        assert code.lstrip().startswith("#pragma once")
        assert "<Eigen/Dense>" not in code, "costs every includer seconds: use Core, Geometry"
    # Bits of libm differ from machine to machine; hash tables and addresses have no order.
    libm = r"\bstd::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|fma)\("
    found = re.search(libm, code)
    assert not found, f"{found[0]}: use math/elementary.hpp"
    assert not re.search(r"\bunordered_|<random>|<ctime>|\brand\(|system_clock", code)
    # Python's build flags define NDEBUG.
    assert not re.search(r"<cassert>|(?<!static_)\bassert\(", code), "assert() is compiled out"


def imports(path: Path) -> set[str]:
    """Full names of the modules a Python file imports, wherever in the file it does."""
    package = ".".join(path.relative_to(ROOT).with_suffix("").parts[:-1])
    package = package.replace("nodes", "rb_physics_nodes", 1)
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*parts, node.module or ""]).strip(".") if node.level else node.module
            found |= {base, *(f"{base}.{name.name}" for name in node.names)}
    return found


PYTHON = sorted((ROOT / "rb_physics").rglob("*.py"))
NODES = sorted((ROOT / "nodes").rglob("*.py"))


@pytest.mark.parametrize("path", PYTHON, ids=relative)
def test_simulator_knows_no_ros_and_no_later_layer(path: Path) -> None:
    names = imports(path)
    for ros in ("rclpy", "rb_physics_nodes", "ament_index_python", "launch"):
        assert not any(name.split(".")[0] == ros for name in names), f"{ros} belongs in nodes/"
    assert not any(re.fullmatch(r"\w+_msgs(\..*)?", name) for name in names)
    if path.name != "cli.py":
        assert not any(name.startswith("rb_physics.cli") for name in names)
        if path.parent.name != "recording":
            assert not any(name.startswith("rb_physics.recording") for name in names)


@pytest.mark.parametrize("path", NODES, ids=relative)
def test_nodes_use_the_public_simulator_only(path: Path) -> None:
    assert not any(name.startswith("rb_physics._core") for name in imports(path))


def test_import_needs_numpy_only() -> None:
    """Scene files, recording and Rerun load their libraries on use."""
    code = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split('.')[0] in {'yaml', 'jsonschema', 'click', 'tqdm', 'mcap', 'rerun', 'rclpy',
                                  'trimesh', 'scipy', 'pyarrow'}:
            raise ImportError(f'{name} was imported')
sys.meta_path.insert(0, Block())
import rb_physics
assert rb_physics.World
"""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, timeout=60)


def test_readme_map_is_true() -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    tree = re.search(r"## The map\n.*?```\n(.*?)```", readme, flags=re.S)
    assert tree, "README.md has a section 'The map' with a tree"
    shown, stack = set(), []
    for line in tree[1].splitlines():
        depth = (len(line) - len(line.lstrip())) // 2
        names = re.split(r"\s{2,}", line.strip())[0].split()
        for name in names:
            path = "/".join([*stack[:depth], name.rstrip("/")])
            assert (ROOT / path).exists(), f"the map shows {path}, which does not exist"
            assert (ROOT / path).is_dir() == name.endswith("/"), f"{path}: folders end in /"
            shown.add(path)
        stack[depth:] = [names[-1].rstrip("/")]
    tracked = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, timeout=60
    )
    if tracked.returncode != 0:
        pytest.skip("not a git clone: what the map must show is unknown")
    files = [Path(name) for name in tracked.stdout.splitlines()]
    folders = {"/".join(file.parts[:n]) for file in files for n in (1, 2, 3) if len(file.parts) > n}
    wanted = {f for f in folders if not f.startswith((".", "tests/", "benchmarks/", "docs/"))}
    wanted = {f for f in wanted if f.count("/") < 2 or f.startswith("rb_physics/core/")}
    wanted |= {str(file) for file in files if len(file.parts) == 1 and file.name[0] != "."}
    wanted |= {str(file) for file in files if str(file.parent) == "rb_physics"}
    assert wanted - shown == set(), "the map does not show these"


def test_readme_lists_every_topic() -> None:
    readme = (ROOT / "README.md").read_text("utf-8")
    for topic in yaml.safe_load((ROOT / "msg_configs" / "topics.yaml").read_text())["topics"]:
        kind = topic["type"].split("/")[-1]
        row = rf"^\| {topic['direction']} \| `{re.escape(topic['name'])}` \| {kind} \|"
        assert re.search(row, readme, flags=re.M), f"README has no row for {topic['name']}"
    rows = re.findall(r"^\| (?:in|out) \| `([^`]+)`", readme, flags=re.M)
    listed = yaml.safe_load((ROOT / "msg_configs" / "topics.yaml").read_text())["topics"]
    assert sorted(rows) == sorted(topic["name"] for topic in listed)


def test_version_is_the_same_everywhere() -> None:
    cfg = re.search(r"^version = (.+)$", (ROOT / "setup.cfg").read_text(), flags=re.M)
    xml = re.search(r"<version>(.+)</version>", (ROOT / "package.xml").read_text())
    assert cfg is not None
    assert xml is not None
    assert cfg[1] == xml[1]
