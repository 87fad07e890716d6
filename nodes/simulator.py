"""The ROS 2 node around a simulated world."""

from __future__ import annotations

import dataclasses
import threading
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError, load_topics, new_run_directory
from rb_physics.recording.errors import FolderExistsError
from rb_physics.recording.operations import CHANGE_BODIES
from rb_physics.recording.rerun_log import require
from rb_physics.recording.topics import Topic

from .complaints import Complaints
from .diagnostics import Diagnostics
from .inputs import Inputs
from .pacer import Pacer
from .physics_loop import PhysicsLoop
from .publishing import Publishing
from .services import Services
from .simulation_interfaces import SimulationInterfaces, load_messages
from .subscribing import Subscribing

LONGEST_STEP = 5.0  # s of wall time that a step may take when the run is to end


class StuckError(RuntimeError):
    """A step doesn't come to its end."""


class Simulator:
    """Builds the world of a scene, steps it in a thread of its own, and connects it to `node`.

    Everything is made by the constructor, which raises ValueError, OSError or ImportError with one
    clear sentence when something is wrong; `activate` lets the simulation run, `deactivate` holds
    it, `close` ends it with its log closed and takes its topics and services away.

    Parameters
    ----------
    values: the node's parameters by name.
    """

    def __init__(self, node: Node, values: dict[str, Any]) -> None:
        self._node = node
        scene = rb.load_scene(values["scene"])
        world = scene.build()
        self._complaints = Complaints(self._log_warning)
        self.recorder = self._make_recorder(scene, world, values)
        try:
            self._connect(world, values)
        except BaseException:
            self.recorder.close()
            raise

    def _make_recorder(self, scene: Any, world: Any, values: dict[str, Any]) -> Recorder:
        topics = load_topics(values["topics"] or None)
        clock = {"rate": 0.0 if values["lockstep"] else values["clock_rate"]}
        topics = dataclasses.replace(
            topics,
            entries=tuple(
                dataclasses.replace(entry, **clock) if entry.content == "clock" else entry
                for entry in topics.entries
            ),
        )
        parent = values["record_dir"]
        rerun = values["rerun"]
        if rerun != "off" and not parent:
            raise ValueError(f"rerun is '{rerun}', but record_dir is empty: set record_dir as well")
        if rerun != "off":
            try:
                require()
            except RecordingError as error:
                self._node.get_logger().warning(f"running without the Rerun view: {error}")
                rerun = "off"
        make = partial(
            Recorder,
            world,
            scene=scene,
            topics=topics,
            rerun=rerun,
            node_name=self._node.get_fully_qualified_name(),
            snapshot_interval=values["snapshot_interval"],
            **_log_options(values),
        )
        if not parent:
            return make(directory=None)
        while True:
            try:
                return make(directory=new_run_directory(parent))
            except FolderExistsError:  # another node began a run in the same second
                continue

    def _connect(self, world: Any, values: dict[str, Any]) -> None:
        self._world = world
        self.inputs = Inputs(
            world,
            self._input_topics(),
            values["wrench_timeout"],
            values["cmd_vel_timeout"],
            values["lockstep"],
            self._complain,
        )
        self.pacer = Pacer(world.settings.dt, values["real_time_factor"])
        self.recorder.outputs.statuses = Diagnostics(world, self.inputs, self.pacer, self.recorder)
        self.publishing = Publishing(self._node, world, self.recorder)
        self.loop = PhysicsLoop(
            world,
            self.inputs,
            self.publishing,
            self.pacer,
            self.perform,
            paused=values["start_paused"],
            duration=values["duration"],
            log=self._log_error,
            save=self._save,
            spawned=lambda: self.recorder.spawned,
        )
        self._subscribing = Subscribing(
            self._node, self.inputs, self.loop.commands, lambda: self.publishing.publishers
        )
        self._services: list[Any] = [Services(self._node, self.loop, self.perform)]
        messages = load_messages()
        if messages is not None:
            further = SimulationInterfaces(self.loop, self.perform, *messages)
            further.offer(self._node)
            self._services.append(further)
        self.recorder.outputs.running = lambda: self.loop.state
        self.publishing.stands_still = lambda: self.loop.stands_still
        self.loop.held = True
        self._thread = threading.Thread(target=self.loop.run, name="physics", daemon=True)
        self._thread.start()  # it answers orders from now on; time waits for `activate`

    def perform(self, name: str, **arguments: Any) -> None:
        """Change the world, log it and say so; topics follow the bodies. In the physics thread.

        Raises ValueError or KeyError when the change is not possible; then nothing has changed.
        """
        if name == "add_body":
            self.recorder.outputs.check_name(str(arguments["description"]["name"]))
        before = self._world.bodies
        self.publishing.perform(name, **arguments)
        if name in CHANGE_BODIES and self._world.bodies != before:
            self.publishing.fit()
            self.inputs.fit(self._world, self._input_topics())
            self._subscribing.fit()
            if name in ("add_body", "remove_body"):  # the loop itself sends all after a reset
                self.publishing.start(self._world)

    def _input_topics(self) -> list[Topic]:
        return [topic for topic in self.recorder.outputs.topics if topic.direction == "in"]

    def activate(self) -> None:
        """Let the simulation run; it begins at the first call."""
        self._subscribing.start()
        self.loop.commands.ask("hold", False)

    def deactivate(self) -> None:
        """Let time stand still until `activate`."""
        self.loop.commands.ask("hold", True)

    def close(self) -> BaseException | None:
        """End the simulation and close its log. Returns what broke it, if anything did."""
        self.loop.stop()
        self._thread.join(LONGEST_STEP)
        if self._thread.is_alive():
            return self._give_up()
        self._subscribing.stop()
        self.publishing.finish()
        error = self.loop.error
        try:
            self.recorder.close()
        except (OSError, ValueError) as failure:
            error = error or failure
        for part in (self._subscribing, self.publishing, *self._services):
            part.destroy(self._node)
        return error

    def _give_up(self) -> BaseException:
        """A step doesn't come to its end: keep what is logged. The process can only be left now."""
        self.recorder.abandon()
        return StuckError(
            f"a step has taken more than {LONGEST_STEP:g} s and is given up; what was logged before it "
            "is kept: look for huge forces or speeds"
        )

    def parameters_changed(self, changes: list[Parameter]) -> None:
        """Parameters have new values, checked before."""
        setters = {
            "real_time_factor": self.pacer.set_factor,
            "wrench_timeout": self.inputs.wrenches.set_timeout,
            "cmd_vel_timeout": self.inputs.motions.set_timeout,
        }
        for change in changes:
            if change.name in setters:
                self.loop.commands.ask("set", setters[change.name], change.value)

    def _complain(self, key: str, text: str) -> None:
        self._complaints(key, text)

    def _log_warning(self, text: str) -> None:
        self._node.get_logger().warning(text)
        self.recorder.event("WARN", text)

    def _log_error(self, text: str) -> None:
        self._node.get_logger().error(text)
        self.recorder.event("ERROR", text)

    def _save(self, world: Any) -> str:
        directory = self.recorder.directory
        if directory is None:
            raise ValueError("nothing saved: start the node with record_dir to have a place for it")
        path = Path(directory) / f"snapshot_{world.step_count:09d}.bin"
        try:
            with open(path, "xb") as file:
                file.write(world.save())
        except FileExistsError:
            raise ValueError(
                f"nothing saved: {path} exists already and is never overwritten; a step later it "
                "has another name"
            ) from None
        return str(path)


def _log_options(values: dict[str, Any]) -> dict[str, Any]:
    """The options of the log among the node's parameters, 0 being no limit to a file."""
    options = {key: values[f"log_{key}"] for key in ("compression", "chunk_bytes", "policy")}
    options |= {"queue_bytes": values["log_queue_bytes"], "fsync": values["log_fsync"]}
    limits = {key: values[f"log_{key}"] or None for key in ("split_bytes", "split_duration")}
    return options | limits
