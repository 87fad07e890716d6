"""Every way to install gives a working sim_node: pip (plain, editable) and colcon (plain, symlinks).

The installs go into folders of their own and see the dependencies of the running environment, so
that nothing is downloaded.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
pytestmark = [pytest.mark.soak, pytest.mark.timeout(3600)]  # each compiles the whole core

# Waits for simulated time to pass 0.1 s; prints where the package came from.
WATCH = """
import sys, time, rclpy
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
rclpy.init()
node = rclpy.create_node("watcher")
seen = []
node.create_subscription(Clock, "/clock", lambda m: seen.append(m.clock.sec + m.clock.nanosec * 1e-9),
                         qos_profile_sensor_data)
end = time.monotonic() + 40
while time.monotonic() < end and not (seen and seen[-1] > 0.1):
    rclpy.spin_once(node, timeout_sec=0.1)
sys.exit(0 if seen and seen[-1] > 0.1 else f"no clock: {seen[-3:]}")
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """A copy of the source tree without anything built."""
    unwanted = shutil.ignore_patterns(
        ".git", ".venv", "build", "install", "log", "*.so", "*.egg-info", "__pycache__", "[0-9]*"
    )
    return Path(shutil.copytree(ROOT, tmp_path / "ws" / "src" / "rb_physics", ignore=unwanted))


@pytest.fixture
def environment(tmp_path: Path) -> Path:
    """Python of a new virtual environment that also sees the packages of the running one."""
    venv.create(tmp_path / "venv", with_pip=False, symlinks=True)
    python = tmp_path / "venv" / "bin" / "python"
    purelib = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        capture_output=True, text=True, check=True, timeout=60,
    ).stdout.strip()  # fmt: skip
    outer = sysconfig.get_path("purelib")
    Path(purelib, "outer.pth").write_text(f"import site; site.addsitedir({outer!r})\n")
    return python


def clean_environment(**more: str) -> dict[str, str]:
    """What a user's shell has: nothing of this test run."""
    drop = ("PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")
    kept = {key: value for key, value in os.environ.items() if key not in drop}
    domain = str(100 + os.getpid() % 100)
    return {**kept, "ROS_DOMAIN_ID": domain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", **more}


def outer_libraries() -> str:
    """LD_LIBRARY_PATH of the running environment's ROS wheels, which look for themselves only in
    the environment that Python was started from."""
    wheels = sorted(map(str, Path(sysconfig.get_path("purelib")).glob("ros_*.libs")))
    return os.pathsep.join([str(Path(sys.prefix) / "lib"), *wheels])


def run(*command: object, **options: object) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, timeout=900, **options
    )
    assert done.returncode == 0, f"{command}:\n{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def check_sim_node(command: list[str], elsewhere: Path, env: dict[str, str]) -> None:
    """Starts it in an unrelated folder, waits for its clock, stops it with SIGINT."""
    arguments = ["--ros-args", "-p", "scene:=single_box", "-p", "record_dir:=runs"]
    node = subprocess.Popen(
        [*command, *arguments], cwd=elsewhere, env=env, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    try:
        run(sys.executable, "-c", WATCH, cwd=elsewhere, env=clean_environment())
        node.send_signal(signal.SIGINT)
        output, _ = node.communicate(timeout=30)
    finally:
        if node.poll() is None:
            node.kill()
            print(node.communicate()[0])
    assert node.returncode == 0, output
    assert "Traceback" not in output
    assert list(elsewhere.glob("runs/*/metadata.yaml")), output


@pytest.mark.parametrize("editable", [False, True], ids=["plain", "editable"])
def test_pip_install(source: Path, environment: Path, tmp_path: Path, editable: bool) -> None:
    env = clean_environment(LD_LIBRARY_PATH=outer_libraries())
    what = ["-e", source] if editable else [source]
    pip = [sys.executable, "-m", "pip", "--python", environment, "install", "-q", "--no-deps"]
    run(*pip, "--no-build-isolation", *what, env=env, cwd=tmp_path)
    if not editable:
        shutil.rmtree(source)  # an install must not need it
    where = "import rb_physics, rb_physics_nodes as n; print(rb_physics.__file__, n.__file__)"
    for file in run(environment, "-c", where, env=env, cwd=tmp_path).split():
        assert Path(file).is_relative_to(source if editable else tmp_path / "venv")
    command = environment.with_name("rb_physics")
    assert "demo" in run(command, "scenes", env=env, cwd=tmp_path)
    check_sim_node([str(environment.with_name("sim_node"))], tmp_path, env)


@pytest.mark.parametrize("symlink", [False, True], ids=["plain", "symlink"])
def test_colcon_build(source: Path, tmp_path: Path, symlink: bool) -> None:
    pytest.importorskip("colcon_ros", reason="colcon comes with the extra dev")
    workspace, env = source.parents[1], clean_environment()
    run(
        sys.executable, "-m", "colcon", "build", *(["--symlink-install"] if symlink else []),
        cwd=workspace, env=env,
    )  # fmt: skip
    prefix = workspace / "install" / "rb_physics"
    marker = prefix / "share/ament_index/resource_index/packages/rb_physics"
    assert marker.exists()
    for file in ("package.xml", "msg_configs/topics.yaml", "scenes/demo.yaml"):
        assert (prefix / "share/rb_physics" / file).is_file()
    if not symlink:
        shutil.rmtree(source)
        shutil.rmtree(workspace / "build")
    setup = workspace / "install" / "setup.bash"
    command = ["bash", "-c", f'. {setup} && exec {prefix}/lib/rb_physics/sim_node "$@"', "sim_node"]
    where = f". {setup} && {sys.executable} -c 'import rb_physics; print(rb_physics.__file__)'"
    file = Path(run("bash", "-c", where, cwd=tmp_path, env=env).strip())
    assert file.resolve().is_relative_to(workspace)
    check_sim_node(command, tmp_path, env)
