"""Real processes around a test: sim_node started for it, and a client that talks to it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

rclpy = pytest.importorskip("rclpy", reason="ROS 2 (rclpy) is not installed")

from rclpy.context import Context  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402

TIMEOUT = 30.0  # s of wall time for anything that must happen; generous for loaded machines


def wait_for(condition: Callable[[], Any], what: str, timeout: float = TIMEOUT) -> Any:
    """Poll until `condition` is true and return its value; fail with `what` after `timeout`."""
    end = time.monotonic() + timeout
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            pytest.fail(f"waited {timeout:g} s in vain for {what}")
        time.sleep(0.005)


class NodeProcess:
    """A Python module run as a process of its own, its output collected."""

    def __init__(self, module: str, arguments: list[str], domain: int, **environment: str) -> None:
        self._output = tempfile.TemporaryFile("w+")  # noqa: SIM115 (closed by close)
        env = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "PYTHONUNBUFFERED": "1",
            **environment,
        }
        self.process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            env=env,
        )

    @property
    def output(self) -> str:
        """Everything it has printed so far."""
        self._output.seek(0)
        return self._output.read()

    def wait(self, timeout: float = TIMEOUT) -> int:
        """Exit code, once it ends by itself."""
        try:
            return self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            pytest.fail(f"the process did not end within {timeout:g} s; it said:\n{self.output}")

    def stop(self, number: int = signal.SIGINT) -> int:
        """Send a signal and return the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.wait()

    def close(self) -> None:
        """End it and let go of its output."""
        self.stop()
        self._output.close()


def parameters(**values: Any) -> list[str]:
    """Command line arguments that set parameters of a node."""
    arguments = ["--ros-args"]
    for name, value in values.items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        arguments += ["-p", f"{name}:={text}"]
    return arguments


class Client:
    """A ROS node of the test with an executor thread; messages are collected per topic."""

    def __init__(self, domain: int, name: str = "test_client") -> None:
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except Exception:  # the context of a finished test is gone
            if self._context.ok():
                raise

    def close(self) -> None:
        """End the thread and leave the domain."""
        self._executor.shutdown(timeout_sec=5.0)
        self._thread.join(5.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def collect(self, kind: Any, topic: str, latched: bool = False, depth: int = 1000) -> list[Any]:
        """A list that grows with every message on `topic`; waits until the publisher is found."""
        received: list[Any] = []
        qos = QoSProfile(
            depth=depth,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        self.node.create_subscription(kind, topic, received.append, qos)
        wait_for(lambda: self.node.count_publishers(topic) > 0, f"a publisher of {topic}")
        return received

    def publisher(self, kind: Any, topic: str) -> Any:
        """A publisher whose topic somebody listens to."""
        publisher = self.node.create_publisher(kind, topic, 100)
        wait_for(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        return publisher

    def call(self, kind: Any, name: str, request: Any = None) -> Any:
        """Call a service and return its response."""
        client = self.node.create_client(kind, name)
        try:
            wait_for(client.service_is_ready, f"the service {name}")
            future = client.call_async(request if request is not None else kind.Request())
            wait_for(future.done, f"an answer of {name}")
            return future.result()
        finally:
            self.node.destroy_client(client)


class Sim:
    """A running sim_node and a client of it."""

    def __init__(self, domain: int, scene: str | Path, **values: Any) -> None:
        values = {"scene": scene, **values}
        self.node = NodeProcess("rb_physics_nodes.sim_node", parameters(**values), domain)
        self.client = Client(domain)

    def close(self) -> None:
        """End both."""
        try:
            self.node.close()
        finally:
            self.client.close()


def operations_on(messages: list[Any], name: str) -> list[Any]:
    """The operations of that name among messages of ~/operations."""
    return [op for op in map(json.loads, (m.data for m in messages)) if op["name"] == name]


def inputs_status(diagnostics: list[Any]) -> dict[str, int]:
    """The counters of the last diagnostics about inputs; empty before any."""
    for message in reversed(diagnostics):
        for status in message.status:
            if status.name == "sim_node: inputs":
                return {item.key: int(item.value) for item in status.values}
    return {}
