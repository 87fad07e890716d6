"""The ROS 2 node around a simulated world."""

from __future__ import annotations

import dataclasses
import threading
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter

import rb_physics as rb
from rb_physics.recording import Recorder, RecordingError, load_topics, new_run_directory
from rb_physics.recording.rerun_log import require

from . import parameters
from .complaints import Complaints
from .diagnostics import Diagnostics
from .inputs import Inputs
from .pacer import Pacer
from .physics_loop import PhysicsLoop
from .publishing import Publishing
from .services import Services
from .simulation_interfaces import SimulationInterfaces, load_messages
from .subscribing import Subscribing


class Simulator:
    """Builds the world of a scene, steps it in a thread of its own, and connects it to `node`.

    Everything is made by the constructor, which raises ValueError, OSError or ImportError with one
    clear sentence when something is wrong; `start` lets the simulation run, `stop` ends it with
    its log closed.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        table = parameters.load_table()
        values = parameters.declare(node, table)
        node.add_on_set_parameters_callback(lambda changes: parameters.check(table, changes))
        node.add_post_set_parameters_callback(self._parameters_changed)

        scene = rb.load_scene(values["scene"])
        world = scene.build()
        self._complaints = Complaints(node.get_logger().warning)
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
        directory = new_run_directory(values["record_dir"]) if values["record_dir"] else None
        rerun = values["rerun"]
        if rerun != "off" and directory is None:
            raise ValueError(f"rerun is '{rerun}', but record_dir is empty: set record_dir as well")
        if rerun != "off":
            try:
                require()
            except RecordingError as error:
                self._node.get_logger().warning(f"running without the Rerun view: {error}")
                rerun = "off"
        return Recorder(
            world,
            directory,
            scene=scene,
            topics=topics,
            rerun=rerun,
            node_name=self._node.get_fully_qualified_name(),
        )

    def _connect(self, world: Any, values: dict[str, Any]) -> None:
        self.inputs = Inputs(
            world,
            [topic for topic in self.recorder.outputs.topics if topic.direction == "in"],
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
            self.publishing.perform,
            paused=values["start_paused"],
            duration=values["duration"],
            log=self._log_error,
            save=self._save,
        )
        self._subscribing = Subscribing(self._node, self.inputs, self.loop.commands)
        self._services = Services(self._node, self.loop.commands)
        messages = load_messages()
        if messages is not None:
            SimulationInterfaces(self.loop, self.publishing.perform, *messages).offer(self._node)
        self._thread = threading.Thread(target=self.loop.run, name="physics")

    def start(self) -> None:
        """Let the simulation run."""
        self._subscribing.start()
        self._thread.start()

    def stop(self) -> BaseException | None:
        """End the simulation and close its log. Returns what broke it, if anything did."""
        self.loop.stop()
        if self._thread.is_alive():
            self._thread.join()
        self._subscribing.stop()
        self.publishing.finish()
        try:
            self.recorder.close()
        except (OSError, ValueError) as error:
            return self.loop.error or error
        return self.loop.error

    def _complain(self, key: str, text: str) -> None:
        self._complaints(key, text)

    def _log_error(self, text: str) -> None:
        self._node.get_logger().error(text)
        self.recorder.event("ERROR", text)

    def _save(self, world: Any) -> str:
        directory = self.recorder.directory
        if directory is None:
            raise ValueError("nothing saved: start the node with record_dir to have a place for it")
        path = Path(directory) / f"snapshot_{world.step_count:09d}.bin"
        with open(path, "xb") as file:
            file.write(world.save())
        return str(path)

    def _parameters_changed(self, changes: list[Parameter]) -> None:
        setters = {
            "real_time_factor": self.pacer.set_factor,
            "wrench_timeout": self.inputs.wrenches.set_timeout,
            "cmd_vel_timeout": self.inputs.motions.set_timeout,
        }
        for change in changes:
            if change.name in setters:
                self.loop.commands.ask("set", setters[change.name], change.value)
