"""Builds the C++ core and lists the files a ROS 2 install needs; everything else is in setup.cfg.

Environment: CC, CXX ("ccache g++" works), RB_PHYSICS_JOBS (compilers at once, default: cores),
RB_PHYSICS_WERROR=1, RB_PHYSICS_SANITIZE=1 (ASan + UBSan), EIGEN3_INCLUDE_DIR.
"""

import os
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.develop import develop

CALLED_FROM = Path.cwd()
ROOT = Path(__file__).resolve().parent
os.chdir(ROOT)  # colcon and pip may call from elsewhere; setuptools wants relative paths

try:
    import pybind11
    from pybind11.setup_helpers import ParallelCompile, Pybind11Extension
except ImportError:
    sys.exit("rb_physics needs pybind11 2.13 or newer to build: pip install 'pybind11>=2.13'")
# Older ones crash with NumPy 2.
if tuple(int(n) for n in pybind11.__version__.split(".")[:2]) < (2, 13):
    sys.exit(
        f"rb_physics needs pybind11 2.13 or newer to build, found {pybind11.__version__}: "
        "pip install 'pybind11>=2.13'"
    )


def eigen_include_dir() -> str:
    """Folder that holds `Eigen/`: EIGEN3_INCLUDE_DIR, else PyPI's cmeel-eigen, else pkg-config."""
    chosen = os.environ.get("EIGEN3_INCLUDE_DIR")
    if chosen is not None:
        if (Path(chosen) / "Eigen" / "Core").is_file():
            return chosen
        sys.exit(f"EIGEN3_INCLUDE_DIR is {chosen}, which has no Eigen/Core.")
    for entry in sys.path:
        include = Path(entry) / "cmeel.prefix" / "include" / "eigen3"
        if (include / "Eigen" / "Core").is_file():
            return str(include)
    try:
        flags = subprocess.run(
            ["pkg-config", "--cflags-only-I", "eigen3"], capture_output=True, text=True, check=True
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        flags = ""
    for flag in shlex.split(flags):
        if (Path(flag[2:]) / "Eigen" / "Core").is_file():
            return flag[2:]
    sys.exit(
        "rb_physics needs Eigen 3.4 to build: pip install cmeel-eigen, or apt install "
        "libeigen3-dev, or set EIGEN3_INCLUDE_DIR to the folder that holds Eigen/."
    )


def needs_recompile(object_file: str, source: str) -> bool:
    """True unless the object is newer than the source, its headers (from the compiler's .d file)
    and setup.py, which holds the flags."""
    built, rule = Path(object_file), Path(object_file).with_suffix(".d")
    if not (built.exists() and rule.exists()):
        return True
    made = built.stat().st_mtime
    needed = shlex.split(rule.read_text().split(":", 1)[1].replace("\\\n", " "))
    return any(
        not Path(name).exists() or Path(name).stat().st_mtime >= made
        for name in [source, "setup.py", *needed]
    )


class BuildCore(build_ext):
    """Each set of flags gets its own folder of object files, so that none is linked by mistake."""

    def finalize_options(self) -> None:
        super().finalize_options()
        if self.build_temp.endswith(".build-temp"):  # of `pip install -e`, thrown away afterwards
            tag = f"{sysconfig.get_platform()}-{sys.implementation.cache_tag}"
            self.build_temp = f"build/temp.{tag}"
        self.build_temp += "-sanitize" if SANITIZE else "-werror" if WERROR else ""


WERROR = os.environ.get("RB_PHYSICS_WERROR") == "1"
SANITIZE = os.environ.get("RB_PHYSICS_SANITIZE") == "1"

# -ffp-contract=off: fused multiply-adds round differently from machine to machine, and a run must
# repeat bit for bit. For the same reason no -ffast-math and no -march=native.
compile_args = ["-O3", "-g0", "-ffp-contract=off", "-Wall", "-Wextra", "-MMD"]
compile_args += ["-isystem", eigen_include_dir()]
# Vectors of three: loading two of its numbers at once, when they were stored one by one just before,
# waits until the stores are through. A box at rest takes a quarter less time without.
compile_args += ["-DEIGEN_UNALIGNED_VECTORIZE=0"]
link_args: list[str] = []
if WERROR:
    compile_args += ["-Werror"]
if SANITIZE:
    sanitizers = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    compile_args += [*sanitizers, "-O1", "-g", "-fno-omit-frame-pointer"]
    link_args += sanitizers

CORE = Path("rb_physics/core")
core = Pybind11Extension(
    "rb_physics._core",
    sources=sorted(str(path) for path in CORE.rglob("*.cpp")),
    include_dirs=[str(CORE)],
    depends=["setup.py", *sorted(str(path) for path in CORE.rglob("*.hpp"))],
    cxx_std=20,
    extra_compile_args=compile_args,
    extra_link_args=link_args,
)


def shared(folder: str, *patterns: str) -> tuple[str, list[str]]:
    """The files of one folder, installed under share/rb_physics."""
    files = sorted(str(path) for pattern in patterns for path in Path(folder).glob(pattern))
    return f"share/rb_physics/{folder}", files


class Develop(develop):
    """`colcon build --symlink-install` puts its folder of links on PYTHONPATH: the scripts look for
    the package's metadata there."""

    def run(self) -> None:
        super().run()
        link, metadata = (folder / "rb_physics.egg-info" for folder in (CALLED_FROM, ROOT))
        linked = (CALLED_FROM / "setup.py").is_symlink() and metadata.is_dir()
        if linked and not os.path.lexists(link):
            link.symlink_to(metadata, target_is_directory=True)


ParallelCompile("RB_PHYSICS_JOBS", needs_recompile=needs_recompile).install()
setup(
    python_requires=">=3.11",  # in setup.cfg it becomes an object that colcon cannot read
    packages=[
        *find_packages(include=["rb_physics", "rb_physics.*"]),
        "rb_physics_nodes",
        *(f"rb_physics_nodes.{name}" for name in find_packages("nodes")),
    ],
    ext_modules=[core],
    cmdclass={"build_ext": BuildCore, "develop": Develop},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/rb_physics"]),
        ("share/rb_physics", ["package.xml"]),
        shared("launch", "*.py", "*.xml", "*.yaml"),
        shared("msg_configs", "*.yaml", "*.json"),
        shared("scenes", "*.yaml", "*.stl", "*.obj"),
    ],
)
