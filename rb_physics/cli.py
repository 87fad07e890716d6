"""The command `rb_physics`. No ROS needed; every failure is one sentence and a non-zero exit."""

from __future__ import annotations

import math
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .cli_options import (
    NEW_FOLDER,
    layout_option,
    new_png,
    no_rerun_option,
    push_option,
    recording_argument,
)
from .errors import DivergedError, SceneError
from .progress import LateProgress, Progress

if TYPE_CHECKING:
    from .scene import Scene
    from .world import World

BATCH = 100  # steps; long enough not to slow down, short enough to show progress and take Ctrl-C


class _Commands(click.Group):
    """Turns the errors users can cause into one sentence; anything else keeps its traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BrokenPipeError:  # the reader, such as head, has what it wanted
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(0)
        except (SceneError, DivergedError) as error:
            raise click.ClickException(str(error)) from None
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            raise click.ClickException(where + (error.strerror or str(error))) from None
        except ImportError as error:
            raise click.ClickException(
                f"{error.name or error} is missing from this environment: pip install rb_physics "
                "installs everything it needs"
            ) from None
        except ValueError as error:
            if type(error).__module__.split(".")[0] != "rb_physics":
                raise
            raise click.ClickException(str(error)) from None


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="rb_physics", prog_name="rb_physics")
def main() -> None:
    """Simulate rigid bodies in contact, record the run, and look at it."""


@main.command()
def scenes() -> None:
    """List the scenes that come with the package."""
    from .resources import packaged_scenes
    from .scene import load_scene

    for name in packaged_scenes():
        scene = load_scene(name)
        click.echo(f"{name:<16} {scene.data.get('description', '')}")


@main.command()
@click.argument("scene", default="demo")
@click.option(
    "--topics",
    "path",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Another topics.yaml than the packaged one.",
)
@click.option("--node", default="sim_node", show_default=True, help="Name of the node.")
def topics(scene: str, path: Path | None, node: str) -> None:
    """Print the topics that the node has for SCENE (demo), one line each, after checking the file."""
    from .recording.topics import load_topics, topic_lines
    from .scene import load_scene

    table = load_topics(path)
    for line in topic_lines(table.expand(load_scene(scene).build().bodies, node)):
        click.echo(line)


@main.command()
@click.argument("scene")
@click.option(
    "--duration",
    type=click.FloatRange(min=0, min_open=True, max=1e6),
    default=10.0,
    show_default=True,
    metavar="SECONDS",
    help="Simulated time.",
)
@click.option(
    "--record",
    type=NEW_FOLDER,
    metavar="DIR",
    help="Record into this new folder (a rosbag2 bag and a Rerun recording).",
)
@no_rerun_option
def run(scene: str, duration: float, record: Path | None, no_rerun: bool) -> None:
    """Simulate SCENE, a path of a scene file or the name of a packaged scene, as fast as possible."""
    from .scene import load_scene

    if no_rerun and record is None:
        raise click.UsageError("--no-rerun goes with --record DIR only.")
    loaded = load_scene(scene)
    world = loaded.build()
    if math.isnan(duration):  # passes every range
        raise click.UsageError("--duration is nan; it must be a number of seconds.")
    steps = round(duration / world.dt)
    if steps < 1:
        raise click.UsageError(f"--duration {duration} s is less than one step of {world.dt} s.")
    started = time.perf_counter()
    if record is None:
        _simulate(world, steps)
    else:
        _simulate_recorded(world, steps, loaded, record, rerun="off" if no_rerun else "file")
    _report(world, steps, time.perf_counter() - started)
    if record is not None:
        click.echo(f"recorded in {record}; next: rb_physics info {record}")


@main.command()
@recording_argument()
def info(recording: Path) -> None:
    """Summarise RECORDING, the folder of a run."""
    from .recording.summary import summary

    click.echo(summary(recording))


@main.command()
@recording_argument()
@new_png(
    "--png", "Render a picture into this new file instead of opening a window; needs no screen."
)
@click.option(
    "--at",
    "--time",
    "moment",
    type=float,
    metavar="SECONDS",
    help="Time of the recording to show; default: its start, for a picture its middle.",
)
@layout_option
def view(recording: Path, png: Path | None, moment: float | None, layout: str) -> None:
    """Open RECORDING, the folder of a run or a .rrd file, in Rerun."""
    from .recording.render import open_viewer, render_png

    if png is None:
        open_viewer(recording, layout, moment)
        return
    for problem in render_png(recording, png, time=moment, layout=layout):
        click.echo(f"Rerun reports: {problem}", err=True)
    click.echo(f"rendered {png}")


@main.command()
@recording_argument()
def recover(recording: Path) -> None:
    """Make a whole copy, RECORDING_recovered, of a recording that was torn off or damaged."""
    from .recording.recover import recover as make_copy

    result = make_copy(recording)
    left_out = f"{result.torn_bytes} torn bytes and {result.damaged_chunks} damaged chunks left out"
    if result.damaged_attachments:
        left_out += f", and damaged attachments: {', '.join(result.damaged_attachments)}"
    click.echo(
        f"{result.directory}: {result.messages} messages up to {result.until:.3f} s; {left_out}"
    )


@main.command()
@recording_argument()
@click.option("--start", type=float, metavar="SECONDS", help="Begin at the snapshot before.")
@click.option("--threads", type=click.IntRange(min=1), help="Repeat with so many threads.")
def verify(recording: Path, start: float | None, threads: int | None) -> None:
    """Simulate RECORDING again and compare every step; exit code 1 when it differs."""
    from .recording.replay import verify as repeat

    chosen = {} if threads is None else {"threads": threads}
    with LateProgress() as progress:
        result = repeat(recording, start=start, progress=progress, **chosen)
    click.echo(result.text)
    if result.difference is not None:
        sys.exit(1)


@main.command()
@recording_argument()
@click.option(
    "--from", "start", type=float, required=True, metavar="SECONDS", help="Where to part."
)
@click.option("--until", type=float, metavar="SECONDS", help="Default: the end of RECORDING.")
@click.option("--record", type=NEW_FOLDER, required=True, metavar="DIR")
@push_option("--wrench", "wrenches", "F", "Force (N, world axes)")
@push_option("--torque", "torques", "T", "Torque (N m, world axes)")
@click.option("--impact-law", help="Another impact law than recorded.")
@click.option("--stepper", help="Another stepper than recorded.")
@click.option(
    "--set",
    "chosen",
    multiple=True,
    type=(str, str),
    metavar="SETTING VALUE",
    help="Another value than recorded of any field of Settings, as in a scene file; may be given "
    "several times.",
)
@no_rerun_option
def replay(
    recording: Path,
    start: float,
    until: float | None,
    record: Path,
    wrenches: tuple[tuple[str, float, float, float], ...],
    torques: tuple[tuple[str, float, float, float], ...],
    chosen: tuple[tuple[str, str], ...],
    no_rerun: bool,
    **changed: str | None,
) -> None:
    """Continue RECORDING from one of its moments and record what happens: a branch."""
    from .recording.branch import AddedWrench, branch

    settings: dict[str, Any] = {k: value for k, value in changed.items() if value is not None}
    settings |= {name: _value(name, text) for name, text in chosen}
    none = (0.0, 0.0, 0.0)
    with LateProgress() as progress:
        steps = branch(
            recording,
            record,
            start,
            until,
            wrenches=[
                *(AddedWrench(body, (x, y, z)) for body, x, y, z in wrenches),
                *(AddedWrench(body, none, (x, y, z)) for body, x, y, z in torques),
            ],
            rerun="off" if no_rerun else "file",
            progress=progress,
            **settings,
        )
    click.echo(f"{steps} steps recorded in {record}; next: rb_physics compare {recording} {record}")


def _value(name: str, text: str) -> Any:
    """A setting as a scene file would have it."""
    import yaml

    try:
        return yaml.safe_load(text)
    except yaml.YAMLError:
        raise click.UsageError(f"--set {name}: {text!r} is no YAML value.") from None


@main.command()
@recording_argument("first")
@recording_argument("second")
@new_png("--plot", "Draw how far each body is apart, over time, into this new PNG file.")
def compare(first: Path, second: Path, png: Path | None) -> None:
    """Say where poses and velocities of two recordings part; exit code 1 when they do."""
    from .recording.compare import compare as find

    result = find(first, second)
    click.echo(result.text)
    if png is not None:
        from .recording.plot import plot_comparison

        click.echo(plot_comparison(first, second, png))
    if not result.identical:
        sys.exit(1)


@main.command()
@recording_argument()
@click.argument("directory", type=NEW_FOLDER)
@click.option(
    "--format",
    "format_",
    type=click.Choice(["csv", "parquet", "npz"]),
    default="csv",
    show_default=True,
)
def export(recording: Path, directory: Path, format_: str) -> None:
    """Write poses, contact wrenches, contacts and totals of RECORDING into a new folder."""
    from .recording.export import export as write

    for path in write(recording, directory, format_):
        click.echo(path)


@main.command()
@recording_argument()
@click.argument("png", type=click.Path(path_type=Path, dir_okay=False))
def plot(recording: Path, png: Path) -> None:
    """Draw energy, contact forces and heights of RECORDING into a new PNG file."""
    from .recording.plot import plot as draw

    click.echo(draw(recording, png))


def _simulate(world: World, steps: int) -> None:
    with Progress(steps, world.dt) as progress:
        while (left := steps - progress.done) > 0:
            count = min(left, BATCH)
            world.step(count)
            progress(count)


def _simulate_recorded(world: World, steps: int, scene: Scene, folder: Path, rerun: str) -> None:
    from .recording import Recorder, RecordingError, load_topics

    with (
        Recorder(world, folder, scene=scene, topics=load_topics(), rerun=rerun) as recorder,
        Progress(steps, world.dt) as progress,
    ):
        while (left := steps - progress.done) > 0:
            count = min(left, BATCH, recorder.steps_until_due())
            world.step(count)
            recorder.after_step()
            progress(count)
            if recorder.error is not None:
                break
    if recorder.error is not None:
        raise RecordingError(f"the run ended at {world.time:g} s: {recorder.error}")
    if recorder.view_error is not None:
        click.echo(f"{recorder.view_error}; the bag is complete", err=True)


def _report(world: World, steps: int, elapsed: float) -> None:
    simulated = steps * world.dt
    stats = world.stats
    click.echo(
        f"simulated {simulated:g} s in {elapsed:.2f} s ({simulated / elapsed:.1f} times real time): "
        f"{steps} steps, {len(world.bodies)} bodies"
    )
    click.echo(
        f"last step: {len(world.contacts)} contacts, residual {stats.residual:.1e}, "
        f"deepest penetration {stats.max_penetration:.1e} m"
    )
    click.echo(f"state hash {world.state_hash:016x}")
