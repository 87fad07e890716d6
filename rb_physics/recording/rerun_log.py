"""The Rerun view of a recording: bodies, contact forces, applied wrenches, energy, log lines.

`RerunLog` takes the very messages of the bag, so a live view, a file written during the run and
one made from a bag afterwards come from the same code. Columns are sent in batches.
"""

from __future__ import annotations

import json
import math
import socket
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import decoders
from .geometry import BodyDescription, from_json
from .mcap_log import RecordingError
from .message_queue import Entry, MessageQueue
from .operations import from_json as operation_from_json
from .outputs import TOTALS
from .palette import APPLIED, FORCE, KINEMATIC, ForceArrows, body_colors, typical_radius
from .quaternions import rotate, rotate_inverse
from .rerun_blueprint import BLUEPRINTS, blueprint
from .rerun_shapes import NAMED_BODIES, ShapeEntities

_BATCH = 25  # samples sent at once
_MAX_RATE = 100.0  # Hz; more is thinned out in the view, never in the bag
_PLOTTED_BODIES = 12  # contact-force curves; beyond, only the sum of all is plotted
_VIEWER_PORT = 9876  # where a Rerun viewer listens unless told otherwise
_FLOOR = 1e-18  # residual and penetration are drawn as logarithms no smaller than that
_QUEUE_BYTES = 32 * 1024 * 1024


def require(live: bool = False) -> Any:
    """The rerun module. Raises RecordingError when it, or the viewer of a live view, is missing."""
    try:
        import rerun
    except ImportError:
        raise RecordingError(
            "the Rerun view needs the rerun-sdk package: pip install rerun-sdk (with NumPy 2), or "
            "record the bag only and view it from another environment"
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


class _Columns:
    """Samples of one entity until a batch is full: times and, per sample, arrays of rows."""

    def __init__(self, send: Callable[[Any, list[NDArray], list[int]], None]) -> None:
        self._send = send  # (time index, concatenated arrays, rows per sample)
        self._times: list[int] = []
        self._samples: list[tuple[NDArray, ...]] = []

    def add(self, time_ns: int, *arrays: NDArray) -> None:
        self._times.append(time_ns)
        self._samples.append(arrays)
        if len(self._times) >= _BATCH:
            self.flush()

    def flush(self) -> None:
        if not self._times:
            return
        rr = require()
        stamps = np.array(self._times, np.int64).astype("timedelta64[ns]")
        index = rr.TimeColumn("sim_time", duration=stamps)
        joined = [np.concatenate(column) for column in zip(*self._samples, strict=True)]
        counts = [len(sample[0]) for sample in self._samples]
        self._times, self._samples = [], []
        self._send(index, joined, counts)


class RerunLog:
    """Writes one .rrd (and to a viewer when `live`)."""

    def __init__(
        self, path: Path | None, gravity: float, live: bool = False, layout: str = "overview"
    ) -> None:
        """`path` must not exist; None: live only. `layout`: one of BLUEPRINTS.

        Raises RecordingError.
        """
        rr = require(live)
        if layout not in BLUEPRINTS:
            raise RecordingError(f"layout {layout!r} is not one of {', '.join(BLUEPRINTS)}")
        self._layout = layout
        if path is not None and path.exists():
            raise RecordingError(f"{path} exists already and is never overwritten")
        self._rr, self._gravity = rr, gravity
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
        self._columns: dict[str, _Columns] = {}
        self._shapes: ShapeEntities | None = None
        self._poses = np.empty((0, 7))
        self._applied: dict[tuple[str, int], tuple[NDArray, NDArray, bool, float]] = {}
        self._last: dict[tuple[str, str | None], int] = {}  # time of the last sample
        self._forces: dict[str, float] = {}  # N, of bodies since the last sample of contacts
        self._touch_time = 0  # ns, of that sample
        self._has_blueprint = False
        self._passed_over: set[str] = set()  # bodies whose contact wrenches aren't shown

    def feed(self, content: str, body: str | None, time_ns: int, data: bytes) -> None:
        """One message of the log, by what it carries (`Topic.content`) and its body."""
        if body in self._passed_over and content == "contact_wrench":
            return
        take = getattr(self, f"_take_{content}", None)
        if take is None:
            return
        if content in ("poses", "contacts", "totals", "contact_wrench"):
            last = self._last.get((content, body))
            if last is not None and 0 <= time_ns - last < 0.999e9 / _MAX_RATE:
                return
            self._last[content, body] = time_ns
        take(body, time_ns, data)

    def flush(self) -> None:
        for columns in self._columns.values():
            columns.flush()
        if self._shapes is not None:
            self._shapes.flush()

    def close(self) -> None:
        self.flush()
        self._rec.flush(timeout_sec=10)
        self._rec.disconnect()

    # -- contents ---------------------------------------------------------------------------------

    def _take_bodies(self, body: str | None, time_ns: int, data: bytes) -> None:
        self.flush()
        self._bodies = from_json(decoders.decode_string(data))
        self._colors = body_colors(self._bodies)
        self._force_arrows = ForceArrows.of(self._bodies, self._gravity)
        self._row_of = {b.name: row for row, b in enumerate(self._bodies)}
        self._plotted = [b.name for b in self._bodies if b.type == "dynamic"][:_PLOTTED_BODIES]
        moving = [row for row, b in enumerate(self._bodies) if b.type != "static"]
        self._moving = moving if len(moving) <= NAMED_BODIES else []
        self._touching: set[tuple[int, int]] | None = None
        many = len(self._bodies) > NAMED_BODIES
        names = {b.name for b in self._bodies if many}
        self._passed_over = names - set(self._plotted)
        self._shapes = None
        self._style()

    def _style(self) -> None:
        rr, log = self._rr, self._rec.log
        radius = 0.035 * typical_radius(self._bodies)
        for name, color in (("contact_forces", FORCE), ("applied_forces", APPLIED)):
            arrows = rr.Arrows3D.from_fields(colors=[color], radii=[radius])
            log(f"world/{name}", arrows, static=True)
        points = rr.Points3D.from_fields(colors=[FORCE], radii=[1.5 * radius])
        log("world/contact_points", points, static=True)
        colors = [self._colors[row] for row in self._moving]
        trail = rr.Points3D.from_fields(colors=colors or None, radii=[0.8 * radius])
        log("world/trajectories", trail, static=True)
        self._series("plots/contacts/points", "contact points", (118, 183, 178, 255))
        self._series("plots/momentum/linear", "linear [kg m/s]", (78, 121, 167, 255))
        self._series("plots/momentum/angular", "angular about the origin [kg m²/s]", KINEMATIC)
        for name, color in (("kinetic", (89, 161, 79, 255)), ("potential", (78, 121, 167, 255)),
                            ("total", (205, 205, 210, 255))):  # fmt: skip
            self._series(f"plots/energy/{name}", f"{name} [J]", color)
        self._series("plots/solver/residual", "log10 of residual", (176, 122, 161, 255))
        self._series("plots/solver/penetration", "log10 of deepest penetration [m]", FORCE)
        for name in self._plotted:
            color = self._colors[self._row_of[name]]
            self._series(f"plots/contact_force/{name}", f"{name} [N]", color)

    def _series(self, entity: str, name: str, color: tuple[int, ...]) -> None:
        self._rec.log(entity, self._rr.SeriesLines(names=name, colors=[color]), static=True)

    def _take_poses(self, body: str | None, time_ns: int, data: bytes) -> None:
        poses = decoders.decode_pose_array(data)[2]
        if len(poses) != len(self._bodies):
            return  # of before or after a body came or went: its description is on the way
        self._poses = poses
        if self._shapes is None:
            self._shapes = ShapeEntities(self._rec, self._bodies, poses)
            if not self._has_blueprint:
                self._has_blueprint = True
                arrangement = blueprint(self._layout, self._bodies, poses)
                self._rec.send_blueprint(arrangement, make_active=True, make_default=True)
        self._shapes.add(time_ns, poses)
        if self._moving:
            self._positions("world/trajectories", time_ns, poses[self._moving, :3])
        self._add_applied(time_ns)

    def _take_contacts(self, body: str | None, time_ns: int, data: bytes) -> None:
        points = decoders.decode_point_cloud(data)[2]
        places = np.stack([points["x"], points["y"], points["z"]], axis=-1)
        forces = np.stack([points["fx"], points["fy"], points["fz"]], axis=-1)
        self._positions("world/contact_points", time_ns, places)
        carrying = np.any(forces != 0, axis=1)
        self._arrows("world/contact_forces", time_ns, places[carrying], forces[carrying])
        if len(self._bodies) <= NAMED_BODIES:
            self._tell_touches(
                time_ns, set(zip(points["body_a"].tolist(), points["body_b"].tolist(), strict=True))
            )

    def _tell_touches(self, time_ns: int, touching: set[tuple[int, int]]) -> None:
        """Log lines where bodies come to touch and part, as the samples show it."""
        before, self._touching = self._touching, touching
        forces, self._forces = self._forces, {}
        seconds, self._touch_time = (time_ns - self._touch_time) * 1e-9, time_ns
        if before is None:
            return
        for words, pairs in (("touches", touching - before), ("leaves", before - touching)):
            for a, b in sorted(pairs):
                if max(a, b) < len(self._bodies):
                    text = f"{self._bodies[a].name} {words} {self._bodies[b].name}"
                    self._tell(time_ns, "INFO", text)
        seen = {row for pair in touching | before for row in pair}
        for name, force in forces.items():
            if self._row_of.get(name) not in seen:  # touched and gone between two samples
                self._tell(time_ns, "INFO", f"{name} bounces: impulse {force * seconds:.3g} N s")

    def _take_totals(self, body: str | None, time_ns: int, data: bytes) -> None:
        values = dict(
            zip(TOTALS, decoders.decode_multi_array(data, "f8")[1].tolist(), strict=False)
        )
        kinetic, potential = values["kinetic_energy"], values["potential_energy"]
        self._scalar("plots/energy/kinetic", time_ns, kinetic)
        self._scalar("plots/energy/potential", time_ns, potential)
        self._scalar("plots/energy/total", time_ns, kinetic + potential)
        self._scalar("plots/contacts/points", time_ns, values["contacts"])
        for name, letter in (("linear", "p"), ("angular", "L")):
            size = math.hypot(*(values[letter + axis] for axis in "xyz"))
            self._scalar(f"plots/momentum/{name}", time_ns, size)
        for name, value in (("residual", "residual"), ("penetration", "max_penetration")):
            self._scalar(f"plots/solver/{name}", time_ns, math.log10(max(values[value], _FLOOR)))

    def _take_contact_wrench(self, body: str | None, time_ns: int, data: bytes) -> None:
        force = float(np.linalg.norm(decoders.decode_wrench_stamped(data).values[:3]))
        if body in self._plotted:
            self._scalar(f"plots/contact_force/{body}", time_ns, force)
        if body is not None and force > 0.0:
            self._forces[body] = force

    def _take_events(self, body: str | None, time_ns: int, data: bytes) -> None:
        level, _, text = decoders.decode_string(data).partition(" ")
        self._tell(time_ns, level, text)

    def _tell(self, time_ns: int, level: str, text: str) -> None:
        self._rec.set_time("sim_time", duration=np.timedelta64(time_ns, "ns"))
        self._rec.log("log", self._rr.TextLog(text, level=level))

    def _take_operations(self, body: str | None, time_ns: int, data: bytes) -> None:
        operation = operation_from_json(decoders.decode_string(data))
        arguments = operation.arguments
        if operation.name in ("reset", "reset_state"):
            self._applied.clear()
        elif operation.name == "clear_wrenches":
            name, source = arguments.get("body"), arguments.get("source")
            for key in list(self._applied):
                if name in (None, key[0]) and source in (None, key[1]):
                    del self._applied[key]
        elif operation.name == "apply_wrench" and arguments["body"] in self._row_of:
            self._apply(time_ns, arguments)

    def _apply(self, time_ns: int, arguments: Mapping[str, Any]) -> None:
        """Remembers an applied force: place in body coordinates, force, its frame, its end."""
        row = self._row_of[arguments["body"]]
        in_body = arguments.get("frame", "world") == "body"
        point = arguments.get("point")
        if point is None:
            place = np.array(self._bodies[row].center_of_mass)
        elif in_body or row >= len(self._poses):
            place = np.array(point)
        else:
            pose = self._poses[row]
            place = rotate_inverse(pose[None, 3:], (np.array(point) - pose[:3])[None])[0]
        duration = arguments.get("duration")
        until = np.inf if duration is None else time_ns + max(duration * 1e9, 1.5e9 / _MAX_RATE)
        force = np.array(arguments.get("force", (0.0, 0.0, 0.0)))
        self._applied[arguments["body"], arguments.get("source", 0)] = (
            place,
            force,
            in_body,
            until,
        )

    def _add_applied(self, time_ns: int) -> None:
        places, forces = [], []
        for (name, _), (place, force, in_body, until) in self._applied.items():
            row = self._row_of.get(name)
            if row is None or time_ns > until or not force.any():
                continue
            q = self._poses[row : row + 1, 3:]
            places.append(self._poses[row, :3] + rotate(q, place[None])[0])
            forces.append(rotate(q, force[None])[0] if in_body else force)
        shape = (len(places), 3)
        self._arrows(
            "world/applied_forces", time_ns, np.reshape(places, shape), np.reshape(forces, shape)
        )

    # -- columns ----------------------------------------------------------------------------------

    def _column(self, entity: str, columns: Callable[..., Any], *names: str) -> _Columns:
        found = self._columns.get(entity)
        if found is None:

            def send(index: Any, joined: list[NDArray], counts: list[int]) -> None:
                content = columns(**dict(zip(names, joined, strict=True)))
                content = content.partition(counts) if columns_are_lists else content
                self._rec.send_columns(entity, indexes=[index], columns=content)

            columns_are_lists = names != ("scalars",)
            found = self._columns[entity] = _Columns(send)
        return found

    def _scalar(self, entity: str, time_ns: int, value: float) -> None:
        self._column(entity, self._rr.Scalars.columns, "scalars").add(time_ns, np.array([value]))

    def _positions(self, entity: str, time_ns: int, places: NDArray) -> None:
        self._column(entity, self._rr.Points3D.columns, "positions").add(time_ns, places)

    def _arrows(self, entity: str, time_ns: int, origins: NDArray, forces: NDArray) -> None:
        column = self._column(entity, self._rr.Arrows3D.columns, "origins", "vectors")
        column.add(time_ns, origins, self._force_arrows.vectors(forces))


class RerunSink:
    """Feeds a RerunLog from a thread of its own; when it can't follow, the oldest are dropped."""

    def __init__(self, log: RerunLog) -> None:
        self._log = log
        self._queue = MessageQueue(_QUEUE_BYTES, "drop_oldest")
        self._keys: list[tuple[str, str | None]] = []
        self._ids: dict[tuple[str, str | None], int] = {}
        self.error: str | None = None
        self._thread = threading.Thread(target=self._run, name="rerun_log", daemon=True)
        self._thread.start()

    def write(self, messages: list[tuple[str, str | None, int, bytes]]) -> None:
        """(content, body, time in ns, message), in the order of the log."""
        entries = []
        for content, body, time_ns, data in messages:
            key = (content, body)
            if key not in self._ids:
                self._keys.append(key)
                self._ids[key] = len(self._keys) - 1
                if content in ("bodies", "operations", "events"):
                    self._queue.essential.add(self._ids[key])
            entries.append(Entry(self._ids[key], time_ns, 0, data))
        self._queue.put(entries)

    @property
    def dropped(self) -> int:
        return self._queue.dropped

    def close(self) -> None:
        self._queue.close()
        self._thread.join()

    def _run(self) -> None:
        try:
            while True:
                closed = self._queue.closed
                for topic, time_ns, _, data in self._queue.take(0.05):
                    self._log.feed(*self._keys[topic], time_ns, data)
                if closed:
                    self._log.close()
                    return
        except Exception as error:
            # The bag is the archive; a view that breaks must not take the run with it.
            self.error = f"the Rerun view stopped: {error}"
            self._queue.close()


def contents_of(topics_json: bytes, namespace: str) -> dict[str, tuple[str, str | None]]:
    """topic name -> (content, body), from the attachment topics.json and the recorder's own."""
    found: dict[str, tuple[str, str | None]] = {
        namespace + name: (name, None) for name in ("bodies", "operations", "events")
    }
    for topic in json.loads(topics_json):
        if topic["direction"] == "out":
            found[topic["name"]] = (topic["content"], topic["body"])
    return found
