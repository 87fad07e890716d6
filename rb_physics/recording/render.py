"""The view of a recording: opened in the Rerun viewer, or rendered to a PNG without a screen."""

from __future__ import annotations

import contextlib
import json
import math
import socket
import subprocess
import sys
import tempfile
import time as clock
import warnings
from pathlib import Path
from typing import Any

from .decoders import decode_string
from .errors import RecordingError
from .geometry import from_json
from .log_reader import Recording, damage_told
from .new_path import new_file
from .rerun_log import RerunLog, contents_of, require, wrenches_shown

_LOADING = 60.0  # s a viewer gets to start and load
_SETTLE = 9.0  # s the viewer gets to draw after time was set, and to hide its greeting


def write_rrd(recording: str | Path, path: str | Path, layout: str = "overview") -> Path:
    """Makes the .rrd of a bag, by the code that writes it during a run.

    `layout`: overview, contact or debug. Raises RecordingError.
    """
    log = Recording(recording)
    notes = log.custom_data
    topics = log.attachment("topics.json", "was not made by rb_physics: it has no topics.json")
    with damage_told(log):
        namespace = "/" + notes["node_name"].strip("/") + "/"
        contents = contents_of(topics, namespace)
        view = RerunLog(Path(path), json.loads(notes["settings"]), layout=layout, afterwards=True)
        try:
            for message in log.messages(_shown(log, contents, namespace)):
                content, body = contents[message.topic]
                view.feed(content, body, message.log_time, message.data)
        except BaseException:
            view.discard()
            Path(path).unlink(missing_ok=True)  # a part of a view would be taken for all of it
            raise
        view.close()
    return Path(path)


def _shown(log: Recording, contents: dict[str, tuple[str, str | None]], namespace: str) -> set[str]:
    """The topics a view is made of: not the contact wrenches that it passes over.

    Those of bodies that came during the run, which topics.json doesn't know, are put into `contents`.
    """
    bodies: set[str] = set()
    for message in log.messages({namespace + "bodies"}):
        bodies |= wrenches_shown(from_json(decode_string(message.data)))
    for topic, (content, body) in list(contents.items()):
        if content == "contact_wrench" and body is not None and f"/{body}/" in topic:
            for name in sorted(bodies):
                other = topic.replace(f"/{body}/", f"/{name}/", 1)
                contents.setdefault(other, (content, name))
            break
    return {
        topic
        for topic, (content, body) in contents.items()
        if content != "contact_wrench" or body in bodies
    }


def rrd_of(recording: str | Path, folder: Path, layout: str = "overview") -> Path:
    """The .rrd to show: a given .rrd file, the one beside the bag, or a new one in `folder`."""
    recording = Path(recording)
    if recording.suffix == ".rrd" and recording.is_file():
        if layout != "overview":
            raise RecordingError(
                f"{recording} has its layout inside; give the folder of the bag for {layout!r}"
            )
        return recording
    beside = recording / f"{recording.name}.rrd"
    if beside.is_file() and layout == "overview":
        return beside
    return write_rrd(recording, folder / f"{recording.resolve().name}.rrd", layout)


def open_viewer(recording: str | Path, layout: str = "overview", time: float | None = None) -> None:
    """Opens the Rerun viewer, at `time` (s; None: at the start), and waits until it is closed."""
    require()
    _check_time(time)
    with tempfile.TemporaryDirectory() as folder:
        rrd = rrd_of(recording, Path(folder), layout)
        if time is not None:
            time = _moment(rrd, time)
        port = _free_port()
        command = [*_viewer_command(), "--bind", "127.0.0.1", "--port", str(port), str(rrd)]
        with subprocess.Popen(command) as viewer:
            try:
                if time is not None:
                    client = _loaded(viewer, rrd, port, _LOADING)
                    client.set_time("sim_time", duration=time, play_state="paused")
                viewer.wait()
            except RecordingError:
                if viewer.poll() is None:  # open, but not to be commanded
                    viewer.terminate()
                    raise
            except BaseException:
                viewer.terminate()
                raise
    if viewer.returncode != 0:
        raise RecordingError(
            "the Rerun viewer could not open a window here; --png FILE renders without a screen"
        )


def render_png(
    recording: str | Path,
    png: str | Path,
    time: float | None = None,
    timeout: float = _LOADING,
    layout: str = "overview",
) -> list[str]:
    """Renders the view at `time` (s; None: the middle) into a new file; needs a Vulkan driver.

    Returns the problems the viewer reports; none is how it should be. Raises RecordingError.
    """
    require()
    _check_time(time)
    png = new_file(png)
    with tempfile.TemporaryDirectory() as folder:
        return _render(rrd_of(recording, Path(folder), layout), png, time, timeout)


def _render(rrd: Path, png: Path, time: float | None, timeout: float) -> list[str]:
    moment = _moment(rrd, time)
    port = _free_port()
    command = [
        *_viewer_command(), "--headless", "--bind", "127.0.0.1", "--port", str(port),
        "--window-size", "1600x900", str(rrd.resolve()),
    ]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as viewer:
        try:
            client = _loaded(viewer, rrd, port, timeout)
            client.set_time("sim_time", duration=moment, play_state="paused")
            clock.sleep(_SETTLE)
            client.save_screenshot(str(png))
            return [f"{view.name}: {r}" for view in client.get_state().views for r in view.reports]
        finally:
            viewer.terminate()


def _loaded(viewer: Any, rrd: Path, port: int, timeout: float) -> Any:
    """A client of a viewer that has started and loaded its file. Raises RecordingError."""
    from rerun.experimental import ViewerClient

    deadline = clock.monotonic() + timeout
    client: Any = None
    state: Any = None
    while state is None or state.loading or not state.views:
        if viewer.poll() is not None:
            raise RecordingError(
                "the Rerun viewer can't render here; without a screen it needs a software "
                "Vulkan driver: apt install mesa-vulkan-drivers"
            )
        if clock.monotonic() > deadline:
            raise RecordingError(f"the Rerun viewer did not load {rrd} in {timeout:g} s")
        clock.sleep(0.2)
        with contextlib.suppress(RuntimeError, OSError, ValueError):  # not up yet
            client = client or ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            state = client.get_state()
    return client


def _check_time(time: float | None) -> None:
    if time is not None and not (math.isfinite(time) and time >= 0):
        raise RecordingError(f"the time to show is {time}; it must be s of the recording, >= 0")


def _moment(rrd: Path, time: float | None) -> float:
    """s: `time`, or the middle of the recorded time. Raises RecordingError when it lies outside."""
    first, last = _span(rrd)
    if time is None:
        return (first + last) / 2
    if not first <= time <= last:
        raise RecordingError(
            f"the time to show is {time:g} s; the recording goes from {first:g} to {last:g} s"
        )
    return time


def _span(rrd: Path) -> tuple[float, float]:
    """s: the recorded time."""
    from rerun.chunk import RrdReader

    low, high = None, None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that of a killed run has no footer, which does no harm
        reader = RrdReader(str(rrd))
    for chunk in reader.stream():
        batch = chunk.to_record_batch()
        if "sim_time" in batch.schema.names and batch.num_rows:
            import pyarrow.compute as pc

            found = pc.min_max(batch.column("sim_time").cast("int64")).as_py()
            low = found["min"] if low is None else min(low, found["min"])
            high = found["max"] if high is None else max(high, found["max"])
    return (0.0, 0.0) if low is None or high is None else (low * 1e-9, high * 1e-9)


def _viewer_command() -> list[str]:
    """The viewer that came with rerun-sdk; else the one in PATH.

    The program itself: ending the Python script in front of it would leave it running.
    """
    with contextlib.suppress(ImportError):
        import rerun_cli

        program = Path(rerun_cli.__file__).with_name("rerun")
        if program.is_file():
            return [str(program)]
    return [sys.executable, "-m", "rerun"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
