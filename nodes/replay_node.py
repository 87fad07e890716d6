"""`replay_node`: publishes a recording again, with its timing and its bytes.

Parameters: recording (folder), rate (1 is the original speed, 0 as fast as possible), start (s of the
recording's time at which to begin), loop, paused (begin so), inputs (publish the recorded inputs, too),
topics (only these, with spaces between), exclude_topics, seek_time (s, for ~/seek). rate, loop and seek_time may be changed
while it plays. Services, all std_srvs/Trigger and named as those of rosbag2's player: ~/pause ~/resume
~/toggle_paused ~/is_paused ~/play_next ~/seek ~/stop.
"""

from __future__ import annotations

import contextlib
import json
import math
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from .player import Player, check_rate
from .start import (
    SIGNALS,
    StartError,
    check_arguments,
    ignore_signals,
    import_rclpy,
    one_line,
)

NAME = "replay_node"
FAREWELL = 0.5  # s of wall time at most to wait for the readers of each topic at the end


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay until the end, SIGINT or SIGTERM. Returns the exit code."""
    stop = threading.Event()
    for number in SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    try:
        rclpy = import_rclpy()
        check_arguments(arguments)
        from rclpy.signals import SignalHandlerOptions

        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        try:
            Replay(rclpy.create_node(NAME), stop).run()
        except (ValueError, OSError, ImportError) as error:
            raise StartError(one_line(error)) from None
        finally:
            rclpy.try_shutdown()
            ignore_signals()
    except StartError as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    return 0


_INPUTS = ("wrench", "cmd_pose", "cmd_vel")


def _of_later_bodies(
    metadata: dict[str, Any], topics: dict[str, dict[str, Any]]
) -> dict[str, dict[str, Any]]:
    """Topics of bodies that were added during the run, like those of the bodies of its start."""
    alike = {}
    for topic in topics.values():
        if topic["body"]:
            pattern = tuple(
                "" if part == topic["body"] else part for part in topic["name"].split("/")
            )
            alike[pattern] = topic
    found = {}
    for entry in metadata.get("topics_with_message_count", []):
        name, kind = (entry["topic_metadata"][key] for key in ("name", "type"))
        parts = name.split("/")
        if name in topics or "bodies" not in parts[:-2]:
            continue
        at = parts.index("bodies") + 1
        sibling = alike.get((*parts[:at], "", *parts[at + 1 :]))
        default = {"direction": "in" if parts[at + 1] in _INPUTS else "out", "qos": {}}
        found[name] = {**(sibling or default), "name": name, "type": kind, "body": parts[at]}
    return found


class Replay:
    """One recording, its publishers, and the services that command its player."""

    def __init__(self, node: Any, stop: threading.Event) -> None:
        from rb_physics.recording.log_reader import Recording

        from .parameters import check_names, declare_one

        self._node, self._stop = node, stop
        declare = declare_parameter = partial(declare_one, node)
        path = declare("recording", "")
        rate = declare("rate", 1.0)
        start = declare("start", 0.0)
        _nanoseconds("start", start)
        loop, paused = declare("loop", False), declare("paused", False)
        with_inputs = declare("inputs", False)
        declare_parameter("seek_time", 0.0)
        only = set(declare("topics", "").split())
        excluded = set(declare("exclude_topics", "").split())
        check_names(node)
        if not path:
            raise ValueError("set the parameter recording to the folder of a recording")
        check_rate(rate)
        recording = Recording(path)
        recording.load_index()
        span = recording.span()
        if span is None:
            raise ValueError(f"{path} holds no messages: it is empty or damaged")
        self._span = span
        content = recording.attachment(
            "topics.json", "was not made by rb_physics: replay it with ros2 bag play"
        )
        listed = sorted(json.loads(content), key=lambda t: t["direction"] == "out")
        topics = {t["name"]: t for t in listed}  # of an input and an output of one name, the latter
        topics |= _of_later_bodies(recording.metadata, topics)
        for name in sorted((only | excluded) - set(topics)):
            raise ValueError(f"{path} has no topic {name}: `rb_physics info {path}` lists them")
        self._publishers: dict[str, Any] = {}
        latched: set[str] = set()
        for name, topic in topics.items():
            wanted = topic["direction"] == "out" or with_inputs
            wanted = name in only if only else wanted
            if wanted and name not in excluded and self._create(topic) == "transient_local":
                latched.add(name)
        if not self._publishers:
            raise ValueError(
                "no topic is left to publish: set the parameters topics, exclude_topics and inputs to "
                "others"
            )
        self._player = Player(
            recording, set(self._publishers), latched & set(self._publishers), self._publish,
            rate=rate, start=self._moment("start", start), loop=loop, paused=paused,
        )  # fmt: skip
        node.add_on_set_parameters_callback(self._check_parameters)
        node.add_post_set_parameters_callback(self._take_parameters)
        self._make_services()

    def _create(self, topic: dict[str, Any]) -> str:
        """Makes the publisher, if its message is installed; the durability."""
        from rb_physics.recording.topics import Qos

        from .conversions import message_class, qos_profile

        name, qos = topic["name"], Qos(**topic["qos"])
        try:
            kind = message_class(topic["type"])
        except ImportError as error:
            self._node.get_logger().info(f"{name} is not replayed: {error}")
            return ""
        self._publishers[name] = self._node.create_publisher(kind, name, qos_profile(qos))
        return qos.durability

    def _publish(self, message: Any) -> None:
        self._publishers[message.topic].publish(bytes(message.data))

    def run(self) -> None:
        """Play, with the services answered by a thread of their own."""
        from rclpy.duration import Duration
        from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

        executor = SingleThreadedExecutor()
        executor.add_node(self._node)

        def spin() -> None:
            with contextlib.suppress(ExternalShutdownException):
                executor.spin()

        thread = threading.Thread(target=spin, name="replay_services", daemon=True)
        thread.start()
        try:
            self._player.run(self._stop)
            for publisher in self._publishers.values():
                publisher.wait_for_all_acked(Duration(seconds=FAREWELL))
        finally:
            executor.shutdown(timeout_sec=1.0)
            thread.join(1.0)

    # -- commands ---------------------------------------------------------------------------------

    def _make_services(self) -> None:
        from std_srvs.srv import Trigger

        calls: dict[str, Callable[[], tuple[bool, str]]] = {
            "pause": lambda: self._pause(True),
            "resume": lambda: self._pause(False),
            "toggle_paused": lambda: self._pause(not self._player.paused),
            "is_paused": lambda: (self._player.paused, self._where()),
            "play_next": self._play_next,
            "seek": self._seek,
            "stop": self._end,
        }
        for name, call in calls.items():
            self._node.create_service(Trigger, f"~/{name}", _answer(call))

    def _where(self) -> str:
        position = self._player.position
        state = "paused" if self._player.paused else "playing"
        return state if position is None else f"{state} at {position * 1e-9:.9g} s"

    def _pause(self, paused: bool) -> tuple[bool, str]:
        self._player.pause(paused)
        return True, self._where()

    def _play_next(self) -> tuple[bool, str]:
        if self._player.play_next():
            return True, "the next message is on its way"
        return False, "it plays: call ~/pause first"

    def _seek(self) -> tuple[bool, str]:
        try:
            moment = self._moment("seek_time", self._node.get_parameter("seek_time").value)
        except ValueError as error:
            return False, str(error)
        self._player.seek(moment)
        return True, f"goes on from {moment * 1e-9:.9g} s"

    def _end(self) -> tuple[bool, str]:
        self._stop.set()
        return True, "stopped"

    def _check_parameters(self, parameters: Sequence[Any]) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        fixed = {p.name for p in parameters} - {"rate", "loop", "seek_time"}
        if fixed:
            reason = f"{', '.join(sorted(fixed))} can't be changed while it plays"
            return SetParametersResult(successful=False, reason=reason)
        try:
            for parameter in parameters:
                if parameter.name == "rate":
                    check_rate(parameter.value)
                elif parameter.name == "seek_time":
                    self._moment("seek_time", parameter.value)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _take_parameters(self, parameters: Sequence[Any]) -> None:
        """Those that were checked, all of them."""
        for parameter in parameters:
            if parameter.name == "rate":
                self._player.set_rate(parameter.value)
            elif parameter.name == "loop":
                self._player.loop = parameter.value

    def _moment(self, name: str, seconds: float) -> int:
        """ns of a parameter's time. Raises ValueError when the recording is over by then."""
        moment = _nanoseconds(name, seconds)
        first, last = self._span
        if moment > last:
            raise ValueError(
                f"parameter {name} is {seconds:.9g} s, but the recording goes from {first * 1e-9:.9g} to "
                f"{last * 1e-9:.9g} s"
            )
        return moment


def _answer(call: Callable[[], tuple[bool, str]]) -> Callable[[Any, Any], Any]:
    def respond(_: Any, response: Any) -> Any:
        response.success, response.message = call()
        return response

    return respond


def _nanoseconds(name: str, seconds: float) -> int:
    if not (math.isfinite(seconds) and 0.0 <= seconds < 9e9):
        raise ValueError(f"parameter {name} is {seconds}, but must be a time in s, not negative")
    return round(seconds * 1e9)


if __name__ == "__main__":
    sys.exit(main())
