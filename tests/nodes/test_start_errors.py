"""What can be wrong at the start is answered by one sentence and a non-zero exit code."""

import os
import subprocess
import sys

import pytest
from harness import NodeProcess, parameters


def start_and_fail(domain, **values):
    """The one line that sim_node says before it gives up."""
    node = NodeProcess("rb_physics_nodes.sim_node", parameters(**values), domain)
    try:
        code, output = node.wait(), node.output
    finally:
        node.close()
    lines = [line for line in output.splitlines() if line.startswith("sim_node: ")]
    assert code == 2
    assert len(lines) == 1, output
    assert "Traceback" not in output
    return lines[0]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"scene": "nowhere.yaml"}, "nowhere.yaml does not exist"),
        ({"scene": "demmo"}, "did you mean 'demo'"),
        ({"real_time_factor": -1.0}, "real_time_factor is -1.0, but must lie in 0 .. 1000"),
        ({"wrench_timeout": -0.5}, "wrench_timeout is -0.5, but must be >= 0 s, or -1"),
        ({"rerun": "file"}, "set record_dir"),
        ({"rerun": "live"}, "set record_dir"),
        ({"rerun": "sometimes"}, "must be one of off, file, live"),
        ({"real_time": 2.0}, "there is no parameter 'real_time'"),
        ({"lockstep": 3}, "lockstep is 3, but must be a bool"),
        ({"topics": "nowhere.yaml"}, "nowhere.yaml"),
        ({"log_policy": "hope"}, "log_policy is 'hope', but must be one of block, drop_oldest"),
        ({"log_compression": "rar"}, "must be one of zstd, lz4, none"),
        ({"log_queue_bytes": 5}, "log_queue_bytes is 5, but must lie in"),
        ({"snapshot_interval": 0.0}, "snapshot_interval is 0.0, but must lie in"),
    ],
    ids=lambda value: None if isinstance(value, dict) else value[:20],
)
def test_bad_parameters(domain, scene, values, words):
    assert words in start_and_fail(domain, **{"scene": scene, **values})


def test_record_dir_that_is_a_file(domain, scene, tmp_path):
    (tmp_path / "taken").write_text("")
    line = start_and_fail(domain, scene=scene, record_dir=tmp_path / "taken")
    assert "taken" in line


def test_scene_with_an_error_names_file_body_and_field(domain, tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("bodies: [{name: a, shape: {type: sphere, radius: 1}, mass: -1}]")
    line = start_and_fail(domain, scene=path)
    for word in ("bad.yaml", "'a'", "mass", "-1"):
        assert word in line


def without(module, *arguments):
    """A sim_node started by an interpreter in which `module` can't be imported."""
    code = f"import sys; sys.modules[{module!r}] = None\n"
    code += "from rb_physics_nodes.sim_node import main; sys.exit(main())"
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment,
    )


def test_rerun_missing_is_said_and_the_bag_is_logged_all_the_same(scene, tmp_path):
    values = {"scene": scene, "record_dir": tmp_path / "runs", "rerun": "file", "duration": 0.2}
    done = without("rerun", *parameters(**values))
    assert done.returncode == 0, done.stderr
    assert "running without the Rerun view" in done.stderr
    assert "pip install rerun-sdk" in done.stderr
    (run,) = (tmp_path / "runs").iterdir()
    assert list(run.glob("*.mcap"))
    assert not list(run.glob("*.rrd"))


def test_ros_missing():
    done = without("rclpy")
    assert done.returncode == 2
    assert "pip install ros-jazzy-rclpy" in done.stderr
    assert "Traceback" not in done.stderr


def test_middleware_missing():
    """What `import rclpy` raises without the rmw package."""
    code = (
        "import sys, types\n"
        "class Missing(types.ModuleType):\n"
        "    def __getattr__(self, name):\n"
        "        raise ImportError('librmw_fastrtps_cpp.so: cannot open shared object file')\n"
        "sys.modules['rclpy.impl.implementation_singleton'] = Missing('missing')\n"
        "from rb_physics_nodes.sim_node import main; sys.exit(main())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "pip install ros-jazzy-rmw-fastrtps-cpp" in done.stderr


def test_middleware_that_is_not_installed(scene):
    """rcl ends the process when RMW_IMPLEMENTATION names one: the node asks first."""
    done = subprocess.run(
        [sys.executable, "-m", "rb_physics_nodes.sim_node", "--ros-args", "-p", f"scene:={scene}"],
        env={**os.environ, "RMW_IMPLEMENTATION": "rmw_nowhere_cpp"},
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert "rmw_nowhere_cpp" in done.stderr and "RMW_IMPLEMENTATION" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("module", ["sim_node", "replay_node"])
def test_an_argument_that_ros_would_pass_over_is_refused(domain, module):
    node = NodeProcess(f"rb_physics_nodes.{module}", ["scene:=demo"], domain)
    try:
        assert node.wait() == 2
        assert "scene:=demo is no argument of a node" in node.output
    finally:
        node.close()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"nosuch": 1}, "there is no parameter 'nosuch'; the parameters are recording, rate"),
        ({"loop": 3}, "parameter loop is 3, but must be a bool"),
        ({"rate": 0, "start": 1}, "set the parameter recording"),  # whole numbers will do
    ],
)
def test_parameters_of_replay_node_are_checked(domain, given, words):
    node = NodeProcess("rb_physics_nodes.replay_node", parameters(**given), domain)
    try:
        assert node.wait() == 2
        assert words in node.output
        assert "Traceback" not in node.output
    finally:
        node.close()


def test_nodes_started_in_the_same_second_have_a_log_each(domain, tmp_path, scene):
    values = parameters(scene=scene, record_dir=tmp_path / "runs", duration=0.05)
    nodes = [
        NodeProcess("rb_physics_nodes.sim_node", [*values, "-r", f"__node:=sim_{i}"], domain)
        for i in range(4)
    ]
    try:
        assert [node.wait() for node in nodes] == [0] * 4, [node.output for node in nodes]
        assert len(list((tmp_path / "runs").iterdir())) == 4
    finally:
        for node in nodes:
            node.close()


def test_a_topic_too_long_for_ros_is_named(domain, tmp_path):
    name = "a" * 230
    path = tmp_path / "scene.yaml"
    path.write_text(f"bodies: [{{name: {name}, shape: {{type: sphere, radius: 0.1}}, mass: 1}}]")
    assert "ROS takes 247: shorten it, or the name of the body" in start_and_fail(
        domain, scene=path
    )
