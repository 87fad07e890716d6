"""Pictures of the Rerun views: every layout of three scenes, rendered without a screen.

    python -m benchmarks.pictures [--folder build/pictures] [--docs]

Prints each picture's name, and every problem the viewer reports; exit code 1 if there is one. With
--docs the two of the README are cut from them.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.render import render_png
from rb_physics.recording.rerun_blueprint import BLUEPRINTS


class Shot(NamedTuple):
    """A scene, what is done to it at its start, how long it runs, and when the picture is taken."""

    scene: str
    act: Callable[[Recorder], None]
    duration: float  # s
    moment: float  # s


def push_ball(recorder: Recorder) -> None:
    """The ball against the tower."""
    recorder.perform("apply_wrench", body="ball", force=(20.0, 0, 0))


def drag_crate(recorder: Recorder) -> None:
    """Up to sliding: the force is above what friction holds."""
    recorder.perform("apply_wrench", body="box", force=(9.0, 0, 0), point=None)


def push_column(recorder: Recorder) -> None:
    """Two of the hundred bodies are pushed."""
    for name in ("box_0_0", "box_12_2"):
        recorder.perform("apply_wrench", body=name, force=(6.0, 2.0, 0))


SHOTS = (
    Shot("demo", push_ball, 2.0, 1.2),
    Shot("single_box", drag_crate, 1.0, 0.3),
    Shot("hundred_bodies", push_column, 1.5, 1.0),
)


def record(shot: Shot, directory: Path) -> None:
    scene = rb.load_scene(shot.scene)
    world = scene.build()
    with Recorder(world, directory, scene=scene) as recorder:
        shot.act(recorder)
        for _ in range(round(shot.duration / world.dt)):
            world.step()
            recorder.after_step()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=Path("build/pictures"))
    parser.add_argument("--docs", action="store_true", help="write those in docs/images, too")
    options = parser.parse_args()
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    problems = 0
    with tempfile.TemporaryDirectory() as runs:
        for shot in SHOTS:
            run = Path(runs) / shot.scene
            record(shot, run)
            for layout in BLUEPRINTS:
                picture = folder / f"{shot.scene}_{layout}.png"
                picture.unlink(missing_ok=True)
                reports = render_png(run, picture, time=shot.moment, layout=layout)
                print(picture, *reports, sep="\n    ")
                problems += len(reports)
    if options.docs:
        cut_for_docs(folder, Path("docs/images"))
    return 1 if problems else 0


def cut_for_docs(folder: Path, docs: Path) -> None:
    """The README's pictures, without the viewer's frame."""
    from PIL import Image

    demo = Image.open(folder / "demo_overview.png").convert("RGB").crop((0, 38, 1600, 870))
    demo.resize((1200, 624), Image.Resampling.LANCZOS).save(docs / "demo.png", optimize=True)
    many = Image.open(folder / "hundred_bodies_contact.png").convert("RGB")
    many.crop((430, 200, 1130, 630)).save(docs / "hundred_bodies.png", optimize=True)


if __name__ == "__main__":
    sys.exit(main())
