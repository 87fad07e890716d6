"""Scenes and topic tables of the node's benchmarks."""

from __future__ import annotations

from pathlib import Path

import yaml

from rb_physics.recording.topics import default_topics_path

LEVELS = 4  # boxes that stand on each other


def write_scene(folder: Path, bodies: int, dt: float) -> Path:
    """Columns of four boxes, and a probe that falls far away from them."""
    listed: list[dict[str, object]] = [
        {"name": "ground", "type": "static",
         "shape": {"type": "half_space", "normal": [0, 0, 1], "offset": 0}},
    ]  # fmt: skip
    side = max(1, round((bodies / LEVELS) ** 0.5))
    for k in range(bodies):
        column, level = divmod(k, LEVELS)
        place = [0.5 * (column % side), 0.5 * (column // side), 0.1 + 0.2 * level]
        shape = {"type": "box", "half_extents": [0.1, 0.1, 0.1]}
        listed.append({"name": f"body_{k}", "shape": shape, "mass": 1.0, "position": place})
    listed.append(
        {"name": "probe", "shape": {"type": "sphere", "radius": 0.1}, "mass": 1.0,
         "position": [1000, 0, 100000]}
    )  # fmt: skip
    path = folder / f"columns_{bodies}.yaml"
    path.write_text(yaml.safe_dump({"dt": dt, "bodies": listed}))
    return path


def pushed_bodies(count: int) -> list[str]:
    """Boxes of the first columns, and the probe at the end."""
    return [f"body_{k}" for k in range(count - 1)] + ["probe"]


def write_topics(folder: Path, rate: float, everything: bool, per_body: bool) -> Path:
    """The packaged table with poses and contacts (or every output) at `rate` Hz, with or without
    topics for each body."""
    table = yaml.safe_load(default_topics_path().read_text())
    if not per_body:
        table["topics"] = [e for e in table["topics"] if "NAME" not in e["name"].split("/")]
    for entry in table["topics"]:
        fast = everything and entry["content"] not in ("diagnostics", "clock")
        if "rate" in entry and (fast or entry["content"] in ("poses", "contacts")):
            entry["rate"] = rate
    path = folder / "topics.yaml"
    path.write_text(yaml.safe_dump(table))
    return path
