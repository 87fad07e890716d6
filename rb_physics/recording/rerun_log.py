"""The Rerun view of a recording: bodies, contact forces, applied wrenches, energy, log lines.

`RerunLog` takes the very messages of the bag, so a live view, a file written during the run and
one made from a bag afterwards come from the same code. Columns are sent in batches.
"""

from __future__ import annotations

import json
import math
import socket
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .errors import RecordingError
from .geometry import BodyDescription, from_json
from .operations import from_json as operation_from_json
from .palette import DYNAMIC, ForceArrows, body_colors, typical_radius
from .rerun_applied import AppliedWrenches
from .rerun_batch import AFTERWARDS, LIVE, Batch
from .rerun_blueprint import BLUEPRINTS, blueprint
from .rerun_contacts import ContactEntities
from .rerun_events import ContactEvents, LogLines
from .rerun_plots import Plots
from .rerun_shapes import NAMED_BODIES, ShapeEntities

_MAX_RATE = 100.0  # Hz; more is thinned out in the view, never in the bag
_THINNED = ("poses", "contacts", "totals", "contact_wrench")
_PLOTTED_BODIES = len(DYNAMIC)  # contact-force curves: each in a colour of its own
_VIEWER_PORT = 9876  # where a Rerun viewer listens unless told otherwise


def require(live: bool = False) -> Any:
    """The rerun module. Raises RecordingError when it, or the viewer of a live view, is missing."""
    try:
        import rerun
    except ImportError:
        raise RecordingError(
            "the Rerun view needs the rerun-sdk package: pip install rerun-sdk (with NumPy 2), or "
            "record the bag only (--no-rerun; the node: rerun:=off) and view it from another "
            "environment"
        ) from None
    if live:
        _require_viewer()
    return rerun


def _require_viewer() -> None:
    """Raises RecordingError when no viewer listens: Rerun itself would only stall."""
    try:
        socket.create_connection(("127.0.0.1", _VIEWER_PORT), timeout=1.0).close()
    except OSError:
        raise RecordingError(
            f"no Rerun viewer listens on port {_VIEWER_PORT} for the live view: start one first "
            "with the command `rerun`"
        ) from None


class RerunLog:
    """Writes one .rrd (and to a viewer when `live`)."""

    def __init__(
        self,
        path: Path | None,
        settings: Mapping[str, Any],
        live: bool = False,
        layout: str = "overview",
        afterwards: bool = False,
    ) -> None:
        """Args:
            path: must not exist; None: live only.
            settings: the fields of `Settings` the run was made with.
            live: send it to a viewer, too.
            layout: one of BLUEPRINTS.
            afterwards: the run is over; columns may be long.

        Raises RecordingError.
        """
        rr = require(live)
        if layout not in BLUEPRINTS:
            raise RecordingError(f"layout {layout!r} is not one of {', '.join(BLUEPRINTS)}")
        if path is not None and path.exists():
            raise RecordingError(f"{path} exists already and is never overwritten")
        self._rr, self._layout = rr, layout
        self._gravity = float(np.linalg.norm(settings["gravity"]))
        self._combine = str(settings["friction_combine"])
        self._batch = AFTERWARDS if afterwards else LIVE
        name = path.stem if path is not None else "live"
        self._rec = rr.RecordingStream("rb_physics", recording_id=name)
        self._rec.set_log_time_enabled(False)
        self._rec.set_log_tick_enabled(False)
        sinks: list[Any] = []
        if path is not None:
            sinks.append(rr.FileSink(str(path)))
        if live:
            sinks.append(rr.GrpcSink())
        self._rec.set_sinks(*sinks)
        self._rec.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self._bodies: list[BodyDescription] = []
        self._poses = np.empty((0, 7))
        self._samples: Batch[NDArray] = Batch(self._batch, self._send_poses)
        self._shapes: ShapeEntities | None = None
        self._contacts: ContactEntities | None = None
        self._applied: AppliedWrenches | None = None
        self._plots: Plots | None = None
        self._last: dict[tuple[str, str | None], int] = {}  # time of the last sample
        self._events: ContactEvents | None = None
        self._lines = LogLines(self._rec, self._batch)
        self._start: float = math.inf  # ns, of the first message
        self._has_blueprint = False
        self._passed_over: set[str] = set()  # bodies whose contact wrenches aren't shown

    def feed(self, content: str, body: str | None, time_ns: int, data: bytes) -> None:
        """One message of the log, by what it carries (`Topic.content`) and its body."""
        if content == "contact_wrench" and body in self._passed_over:
            return
        take = getattr(self, f"_take_{content}", None)
        if take is None or (self._plots is None and content != "bodies"):
            return
        if content in _THINNED:
            last = self._last.get((content, body))
            if last is not None and 0 <= time_ns - last < 0.999e9 / _MAX_RATE:
                return
            self._last[content, body] = time_ns
        take(body, time_ns, data)

    def flush(self) -> None:
        self._samples.flush()
        self._lines.flush()
        for part in (self._contacts, self._applied, self._plots):
            if part is not None:
                part.flush()

    def close(self) -> None:
        self.flush()
        self._rec.flush(timeout_sec=10)
        self._rec.disconnect()

    def discard(self) -> None:
        """Ends it without what is still gathered."""
        self._rec.disconnect()

    # -- contents ---------------------------------------------------------------------------------

    def _take_bodies(self, body: str | None, time_ns: int, data: bytes) -> None:
        self.flush()
        self._start = min(self._start, time_ns)
        self._bodies = bodies = from_json(decoders.decode_string(data))
        colors = body_colors(bodies)
        self._arrows = arrows = ForceArrows.of(bodies, self._gravity)
        self._row_of = {b.name: row for row, b in enumerate(bodies)}
        plotted = plotted_bodies(bodies)
        moving = [row for row, b in enumerate(bodies) if b.type != "static"]
        self._moving = moving if len(moving) <= NAMED_BODIES else []
        self._events = ContactEvents(bodies, self._lines)
        self._passed_over = {b.name for b in bodies} - wrenches_shown(bodies)
        self._shapes = None
        self._contacts = ContactEntities(self._rec, bodies, arrows, self._combine, self._batch)
        self._applied = AppliedWrenches(self._rec, bodies, arrows, self._batch, self._applied)
        curves = [(name, colors[self._row_of[name]]) for name in plotted]
        self._plots = Plots(self._rec, curves, self._batch)
        trail = self._rr.Points3D.from_fields(
            colors=[colors[row] for row in self._moving] or None,
            radii=[0.028 * typical_radius(bodies)],
        )
        self._rec.log("world/trajectories", trail, static=True)

    def _take_poses(self, body: str | None, time_ns: int, data: bytes) -> None:
        poses = decoders.decode_pose_array(data)[2]
        if len(poses) != len(self._bodies):
            return  # of before or after a body came or went: its description is on the way
        self._poses = poses
        if self._shapes is None:
            self._shapes = ShapeEntities(self._rec, self._bodies, poses)
            if len(self._bodies) > NAMED_BODIES:
                self._lines.add(
                    time_ns,
                    "INFO",
                    f"{len(self._bodies)} bodies: those that touch and part are told, but with more than "
                    f"{NAMED_BODIES} not those that bounce between two samples",
                )
            if not self._has_blueprint:
                self._has_blueprint = True
                arrangement = blueprint(self._layout, self._bodies, poses, self._arrows)
                self._rec.send_blueprint(arrangement, make_active=True, make_default=True)
        self._samples.add(time_ns, poses)
        if self._applied is not None:
            self._applied.add(time_ns, poses)

    def _send_poses(self, index: Any, samples: list[NDArray]) -> None:
        assert self._shapes is not None
        self._lines.flush()  # in step with what they are about
        poses = np.stack(samples)
        self._shapes.send(index, poses)
        if self._moving:
            places = poses[:, self._moving, :3].reshape(-1, 3)
            columns = self._rr.Points3D.columns(positions=places)
            self._rec.send_columns(
                "world/trajectories",
                indexes=[index],
                columns=columns.partition([len(self._moving)] * len(poses)),
            )

    def _take_contacts(self, body: str | None, time_ns: int, data: bytes) -> None:
        assert self._contacts is not None and self._events is not None
        self._events.add_contacts(time_ns, self._contacts.add(time_ns, data))

    def _take_totals(self, body: str | None, time_ns: int, data: bytes) -> None:
        assert self._plots is not None
        self._plots.add_totals(time_ns, data, stepped=time_ns > self._start)

    def _take_contact_wrench(self, body: str | None, time_ns: int, data: bytes) -> None:
        assert self._plots is not None and self._events is not None and body is not None
        if time_ns <= self._start:
            return  # the mean of no time at all
        self._plots.add_wrench(time_ns, body, data)
        if len(self._bodies) <= NAMED_BODIES:
            self._events.add_wrench(body, data)

    def _take_events(self, body: str | None, time_ns: int, data: bytes) -> None:
        level, _, text = decoders.decode_string(data).partition(" ")
        self._lines.add(time_ns, level, text)

    def _take_operations(self, body: str | None, time_ns: int, data: bytes) -> None:
        assert self._applied is not None
        operation = operation_from_json(decoders.decode_string(data))
        self._applied.take(time_ns, operation, self._poses)

    def _take_held_wrenches(self, body: str | None, time_ns: int, data: bytes) -> None:
        assert self._applied is not None
        self._applied.load(decoders.decode_string(data))


def plotted_bodies(bodies: Sequence[BodyDescription]) -> list[str]:
    """Those whose contact force gets a curve."""
    return [b.name for b in bodies if b.type == "dynamic"][:_PLOTTED_BODIES]


def wrenches_shown(bodies: Sequence[BodyDescription]) -> set[str]:
    """Those whose contact wrenches the view uses: for curves, and few bodies' to tell bounces."""
    few = len(bodies) <= NAMED_BODIES
    return {b.name for b in bodies} if few else set(plotted_bodies(bodies))


def contents_of(topics_json: bytes, namespace: str) -> dict[str, tuple[str, str | None]]:
    """topic name -> (content, body) of what `RerunLog.feed` shows, from the attachment topics.json
    and the recorder's own.
    """
    found: dict[str, tuple[str, str | None]] = {
        namespace + name: (name, None)
        for name in ("bodies", "held_wrenches", "operations", "events")
    }
    for topic in json.loads(topics_json):
        if topic["direction"] == "out" and hasattr(RerunLog, f"_take_{topic['content']}"):
            found[topic["name"]] = (topic["content"], topic["body"])
    return found
