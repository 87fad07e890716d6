"""Finds the files that come with the package: scenes and topic configurations.

They lie beside the package in a source tree (also with ``pip install -e`` and
``colcon build --symlink-install``) and under ``share/rb_physics`` of the prefix after an install.
"""

from __future__ import annotations

import difflib
import os
import sys
from pathlib import Path

from .errors import SceneError

PACKAGE = Path(__file__).resolve().parent


def shared_folder(name: str) -> Path:
    """The folder ``scenes``, ``msg_configs`` or ``launch`` of this very installation.

    Raises:
        FileNotFoundError: the folder is in none of the usual places; the message lists them.
    """
    candidates = []
    if (PACKAGE.parent / "package.xml").is_file():
        candidates.append(PACKAGE.parent / name)
    prefixes = [*PACKAGE.parents, Path(sys.prefix)]
    prefixes += [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    candidates += [prefix / "share" / "rb_physics" / name for prefix in prefixes]
    for folder in candidates:
        if folder.is_dir():
            return folder
    places = ", ".join(map(str, dict.fromkeys(candidates)))
    raise FileNotFoundError(f"rb_physics is not fully installed: no folder {name} in {places}")


def packaged_scenes() -> list[str]:
    """Names of the scenes that come with the package, sorted."""
    return sorted(path.stem for path in shared_folder("scenes").glob("*.yaml"))


def scene_path(scene: str | os.PathLike[str]) -> Path:
    """The file meant by a ``scene`` argument.

    Text without a folder and without the ending .yaml or .yml is the name of a packaged scene;
    everything else is a path.

    Raises:
        SceneError: no such file or packaged scene.
    """
    if not isinstance(scene, (str, os.PathLike)) or isinstance(os.fspath(scene), bytes):
        raise SceneError.about(
            None, "scene", scene, "the path of a scene file or the name of a packaged scene"
        )
    path = Path(scene)
    if isinstance(scene, str) and path.name == scene and path.suffix not in (".yaml", ".yml"):
        names = packaged_scenes()
        if scene in names:
            return shared_folder("scenes") / f"{scene}.yaml"
        close = difflib.get_close_matches(scene, names, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise SceneError(
            f"there is no packaged scene {scene!r}{hint} (packaged are {', '.join(names)}; "
            "a scene file of your own is given by its path, ending in .yaml)"
        )
    if not path.is_file():
        what = "is not a file" if path.exists() else "does not exist"
        raise SceneError(
            f"the scene file {path} {what}; give an existing .yaml file or the name of a packaged "
            f"scene ({', '.join(packaged_scenes())})"
        )
    return path
