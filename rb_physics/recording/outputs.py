"""What the simulator sends: the state of a world as (topic, bytes), for node and log alike."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import encoders
from .contact_sums import ContactSums, SensorFrames
from .geometry import BodyDescription, describe
from .markers import MarkerEncoder
from .palette import ForceArrows
from .quaternions import cross, rotate_inverse
from .topics import LATCHED, SENSORS, Topic, TopicTable
from .urdf import scene_urdf
from .worst_steps import WorstSteps

# What shows the state at one moment, and no mean or maximum over an interval.
OF_A_MOMENT = ("clock", "poses", "pose", "odometry", "tf", "contacts", "markers")
Message = tuple[str, bytes]  # topic name, serialised message
Status = tuple[int, str, str, str, dict[str, object]]  # as encoders.encode_diagnostics takes it

# One row of ~/contacts. float32 except where the range needs more; ROS has no 64-bit integers, so
# a feature id is two u4, the low one first.
CONTACT_POINT = np.dtype(
    [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz", "fx", "fy", "fz", "separation")]
    + [("body_a", "<i4"), ("body_b", "<i4"), ("feature", "<u4", 2), ("kind", "u1"), ("state", "u1")]
)
TOTALS = [
    "time",
    "kinetic_energy",
    "potential_energy",
    "px",
    "py",
    "pz",
    "Lx",
    "Ly",
    "Lz",
    "residual",  # this and the rest: the largest of the steps since the message before
    "max_penetration",
    "contacts",
]


class _Group:
    """Topics of one content and rate, encoded together."""

    def __init__(self, topics: list[Topic], encode: Callable[[int], list[bytes]]) -> None:
        self.names = [topic.name for topic in topics]
        self.period_ns = 1e9 / topics[0].rate if topics[0].rate > 0 else 0.0
        self.content = topics[0].content
        self.encode = encode
        self.next_ns = 0.0
        self.last_ns = -1  # time of the last message


class Outputs:
    """Encodes the topics of a table that are due, in the table's order."""

    def __init__(self, world: Any, table: TopicTable, node_name: str = "sim_node") -> None:
        """Raises TopicError when the table doesn't fit the world's bodies."""
        self._world, self._table, self._node_name = world, table, node_name
        self.statuses: Callable[[], Sequence[Status]] | None = None  # the caller's diagnostics
        self.running: Callable[[], tuple[int, str]] = lambda: (0, "running")  # level and text
        self._sums = ContactSums(world)
        self.worst = WorstSteps(world)
        self._rebuilt = False
        self._build(strict=True)
        self.restart()

    def check_name(self, body: str) -> None:
        """Raises TopicError for the name of a body to be added whose topics ROS would not take."""
        taken = {topic.name for topic in self.topics if topic.body != body}
        self._table.check_name(body, self._node_name, taken)

    def rebuild(self) -> None:
        """Call after bodies were added or removed; new topics are in `topics` afterwards."""
        self._rebuilt = True
        self._build(strict=False)
        self._schedule()

    def restart(self) -> None:
        """Call after a jump in time: intervals and rates begin anew at the present time."""
        self._sums.restart(self._time_ns())
        self._schedule()

    def _build(self, strict: bool) -> None:
        world = self._world
        self.bodies: list[BodyDescription] = describe(world.bodies)
        self._row_of = {body.name: row for row, body in enumerate(self.bodies)}
        self.topics = self._table.expand(world.bodies, self._node_name, strict=strict)
        self._dt_ns = float(world.settings.dt) * 1e9
        self._sums.rebuild()
        self._groups: list[_Group] = []
        keyed: dict[tuple, list[Topic]] = {}
        for topic in self.topics:
            if topic.direction == "out" and topic.content not in LATCHED:
                frame = topic.frame if topic.content not in SENSORS else ""
                frame = frame.replace(topic.body or " ", "NAME")
                key = (topic.content, topic.rate, topic.body is None or frame)
                keyed.setdefault(key, []).append(topic)
        for topics in keyed.values():
            build = getattr(self, f"_{topics[0].content}_encoder")
            self._groups.append(_Group(topics, build(topics)))

    def _schedule(self) -> None:
        now = self._time_ns()
        for group in self._groups:
            group.next_ns = now if group.period_ns == 0 else self._next(group, now)
        self._earliest = min((group.next_ns for group in self._groups), default=math.inf)

    def _time_ns(self) -> int:
        now: float = self._world.time
        return round(now * 1e9)

    def _next(self, group: _Group, now: float) -> float:
        """The first multiple of the period after now; half a step early counts as on time."""
        if group.period_ns == 0:
            return now + self._dt_ns
        return (math.floor((now + self._dt_ns / 2) / group.period_ns) + 1) * group.period_ns

    def steps_until_due(self) -> int:
        """Steps until the next output is due, at least 1."""
        ahead = (self._earliest - self._dt_ns / 2 - self._time_ns()) / self._dt_ns
        return max(1, math.ceil(ahead)) if math.isfinite(ahead) else 1_000_000

    def collect(self, everything: bool = False) -> list[Message]:
        """The messages due at the world's present time; cheap when nothing is.

        Contact wrenches are means since their last message, so no impact is lost in between.
        """
        now = self._time_ns()
        late = now + self._dt_ns / 2
        if late < self._earliest and not everything:
            return []
        self._drained = False
        messages: list[Message] = []
        for group in self._groups:
            if late >= group.next_ns or everything:
                messages.extend(zip(group.names, group.encode(now), strict=True))
                group.next_ns, group.last_ns = self._next(group, now), now
        self._earliest = min((group.next_ns for group in self._groups), default=math.inf)
        return messages

    def present(self) -> list[Message]:
        """The state at the world's present time in the topics that have not sent it yet, and the
        diagnostics: for when time stands still between two outputs. Nothing that is due changes."""
        now = self._time_ns()
        messages: list[Message] = []
        for group in self._groups:
            of_a_moment = group.content in OF_A_MOMENT and group.last_ns != now
            if of_a_moment or group.content == "diagnostics":
                messages.extend(zip(group.names, group.encode(now), strict=True))
                group.last_ns = now
        return messages

    def diagnostics(self) -> list[Message]:
        """Those of now, due or not."""
        now = self._time_ns()
        return [
            message
            for group in self._groups
            if group.content == "diagnostics"
            for message in zip(group.names, group.encode(now), strict=True)
        ]

    def latched(self) -> list[Message]:
        """The transient_local topics: to be sent at the start and after `rebuild`."""
        messages = []
        for topic in self.topics:
            if topic.content == "body_names":
                names = json.dumps([body.name for body in self.bodies])
                messages.append((topic.name, encoders.encode_string(names)))
            elif topic.content == "robot_description":
                messages.append((topic.name, encoders.encode_string(scene_urdf(self.bodies))))
            elif topic.content == "tf_static":
                messages.append((topic.name, self._static_transforms()))
        return messages

    def _static_transforms(self) -> bytes:
        parents, children, transforms = [], [], []
        for body in self.bodies:
            frames = {"com": (body.center_of_mass, (0.0, 0.0, 0.0, 1.0)), **body.frames}
            for name, (position, orientation) in frames.items():
                parents.append(body.name)
                children.append(f"{body.name}/{name}")
                transforms.append((*position, *orientation))
        encoder = encoders.TransformEncoder(parents, children)
        return encoder.encode(self._time_ns(), np.array(transforms).reshape(-1, 7))

    # -- one builder per content: _CONTENT_encoder(topics) -> encode(time_ns) -> [bytes, ...] -------

    def _rows(self, topics: list[Topic]) -> NDArray:
        return np.array([self._row_of[topic.body] for topic in topics if topic.body], np.intp)

    def _poses_of(self, rows: NDArray) -> NDArray:
        return np.hstack((self._world.positions[rows], self._world.orientations[rows]))

    def _clock_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        return lambda now: [encoders.encode_clock(now)] * len(topics)

    def _poses_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        encoder = encoders.PoseArrayEncoder(topics[0].frame)

        def encode(now: int) -> list[bytes]:
            data = encoder.encode(now, self._world.positions, self._world.orientations)
            return [data] * len(topics)

        return encode

    def _pose_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        rows = self._rows(topics)
        encoder = encoders.PoseStampedEncoder([topic.frame for topic in topics])
        return lambda now: encoder.encode(now, self._poses_of(rows))

    def _odometry_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        rows, world = self._rows(topics), self._world
        children = [topic.body or "" for topic in topics]
        encoder = encoders.OdometryEncoder([topic.frame for topic in topics], children)

        def encode(now: int) -> list[bytes]:
            q, spin = world.orientations[rows], world.angular_velocities[rows]
            lever = world.positions[rows] - world.com_positions[rows]
            origin = world.linear_velocities[rows] + cross(spin, lever)
            twists = np.hstack((rotate_inverse(q, origin), rotate_inverse(q, spin)))
            return encoder.encode(now, self._poses_of(rows), twists)

        return encode

    def _contact_wrench_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        encoder = encoders.WrenchStampedEncoder([topic.frame for topic in topics])
        frames, key = SensorFrames(topics, self.bodies), (topics[0].content, topics[0].rate)
        self._sums.open(key, topics, self._row_of, self._time_ns())

        def encode(now: int) -> list[bytes]:
            if not self._drained:  # once per collect, for every group that sums up
                self._sums.drain()
                self._drained = True
            wrenches = frames.express(self._world, self._sums.mean(key, now))
            return encoder.encode(now, wrenches)

        return encode

    _pair_wrench_encoder = _contact_wrench_encoder

    def _contacts_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        encoder = encoders.PointCloudEncoder(topics[0].frame, CONTACT_POINT)
        return lambda now: [encoder.encode(now, contact_points(self._world.contacts))] * len(topics)

    def _markers_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        world = self._world
        arrows = ForceArrows.of(self.bodies, float(np.linalg.norm(world.settings.gravity)))
        encoder = MarkerEncoder(topics[0].frame, self.bodies, arrows, anew=self._rebuilt)

        def encode(now: int) -> list[bytes]:
            contacts = world.contacts
            data = encoder.encode(
                now, world.positions, world.orientations, contacts["point"], contacts["force"]
            )
            return [data] * len(topics)

        return encode

    def _tf_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        # A body driven by /tf has its transform from there.
        driven = {name for topic in self.topics for name in topic.bodies}
        names = [body.name for body in self.bodies if body.name not in driven]
        encoder = encoders.TransformEncoder([topics[0].frame] * len(names), names)
        rows = np.array([self._row_of[name] for name in names], np.intp)
        return lambda now: [encoder.encode(now, self._poses_of(rows))] * len(topics)

    def _totals_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        encoder = encoders.MultiArrayEncoder((" ".join(TOTALS),), topics[0].type)
        world, reader = self._world, ("totals", topics[0].rate)
        self.worst.open(reader)

        def encode(now: int) -> list[bytes]:
            values = (
                now * 1e-9,
                world.kinetic_energy,
                world.potential_energy,
                *world.linear_momentum,
                *world.angular_momentum,
                *self.worst.take(reader),
            )
            return [encoder.encode(values)] * len(topics)

        return encode

    def _diagnostics_encoder(self, topics: list[Topic]) -> Callable[[int], list[bytes]]:
        world, name = self._world, self._node_name.strip("/")

        def encode(now: int) -> list[bytes]:
            stats = world.stats
            numbers = {k: getattr(stats, k) for k in dir(stats) if not k.startswith("_")}
            values = {"step": world.step_count, "bodies": len(self.bodies), **numbers}
            level, text = self.running()
            statuses: list[Status] = [(level, f"{name}: physics", text, "", values)]
            if self.statuses is not None:
                statuses.extend(self.statuses())
            return [encoders.encode_diagnostics(now, statuses)] * len(topics)

        return encode


def contact_points(contacts: NDArray) -> NDArray:
    """Rows of `world.contacts` as CONTACT_POINT."""
    points = np.zeros(len(contacts), CONTACT_POINT)
    for axis, letter in enumerate("xyz"):
        points[letter] = contacts["point"][:, axis]
        points["n" + letter] = contacts["normal"][:, axis]
        points["f" + letter] = contacts["force"][:, axis]
    for name in ("separation", "body_a", "body_b", "kind", "state"):
        points[name] = contacts[name]
    feature = np.ascontiguousarray(contacts["feature"], "<i8")
    points["feature"] = feature.view("<u4").reshape(-1, 2)
    return points
