"""Makes sure that the tests see the build they are meant for.

`python -m pytest` puts the source tree before an installed build. That is right when the core was
built in place, and wrong when it was not. RB_PHYSICS_TEST_BUILD names a folder the package must
come from (`make sanitize`).
"""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILT_IN_PLACE = list((ROOT / "rb_physics").glob("_core.*.so"))
DEMANDED = os.environ.get("RB_PHYSICS_TEST_BUILD")

if DEMANDED or not BUILT_IN_PLACE:
    sys.path[:] = [p for p in sys.path if Path(p or ".").resolve() != ROOT]
    sys.path.append(str(ROOT))  # for the helpers of tests; last, so that the build comes first


def pytest_sessionstart(session: pytest.Session) -> None:
    try:
        import rb_physics._core as core
    except ImportError as error:
        pytest.exit(
            f"rb_physics is not built ({error}): run `make build`, or "
            "`python setup.py build_ext --inplace`",
            returncode=4,
        )
    built = Path(core.__file__).resolve()
    if DEMANDED and not built.is_relative_to(Path(DEMANDED).resolve()):
        pytest.exit(f"the tests would use {built}, not the build in {DEMANDED}", returncode=4)
    if built.is_relative_to(ROOT):
        sources = [p for end in ("*.cpp", "*.hpp") for p in (ROOT / "rb_physics/core").rglob(end)]
        newest = max(sources, key=lambda path: path.stat().st_mtime)
        if newest.stat().st_mtime > built.stat().st_mtime:
            pytest.exit(
                f"{built.name} is older than {newest.relative_to(ROOT)}: run `make build`",
                returncode=4,
            )


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[tuple[Path, Callable[[str], None]]]:
    """A file system of 4 MB, and the means to mount it again with other options."""
    mount = tmp_path / "disk"
    mount.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(mount)]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("a small file system can only be mounted by root")

    def remount(options: str) -> None:
        subprocess.run(["mount", "-o", f"remount,{options}", str(mount)], check=True)

    try:
        yield mount, remount
    finally:
        subprocess.run(["umount", "-l", str(mount)], check=True)
