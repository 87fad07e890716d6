"""The node under load, beside a plain rclpy node: steps lost, lateness, latency, CPU.

    python -m benchmarks.node_loop [--seconds 60] [--bodies 100] [--hz 1000] [--wrenches 200]
                                   [--single] [--all-outputs] [--no-body-topics] [--no-plain]

100 bodies at 1 kHz, poses and contacts every step, the other topics at their packaged rates,
logging on; a second process sends wrenches to 20 bodies 200 times a second each (in one batched
message; --single: on 20 topics) and measures the time from a wrench to the first pose that shows
it. Then the same with a timer and message objects (plain_node). The other case is `--bodies 1000
--hz 250 --no-body-topics`: a wrench topic out and in for each of a thousand bodies is 100 000 messages
a second. Run it on a quiet machine.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from rb_physics_nodes.own_domain import use_own_domain

from benchmarks.node_scenes import write_scene, write_topics

PUSHED = 20  # bodies that get wrenches
SETTLE = 5.0  # s the nodes run longer than the client, which first has to find them


def start(*arguments: object) -> subprocess.Popen[str]:
    """A Python module as a process of its own, its output to be read."""
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def client(options: argparse.Namespace, how: str) -> subprocess.Popen[str]:
    """The process that pushes and watches."""
    return start("benchmarks.node_client", "/sim_node", options.seconds, options.wrenches, how,
                 PUSHED)  # fmt: skip


def run_node(options: argparse.Namespace, folder: Path, scene: Path) -> dict[str, Any]:
    """sim_node and the client; the node's last diagnostics and the client's figures."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray

    last: dict[str, Any] = {}
    shares: list[float] = []

    def read(message: DiagnosticArray) -> None:
        for status in message.status:
            last[status.name.removeprefix("sim_node: ")] = {i.key: i.value for i in status.values}
        shares.append(float(last["timing"]["cpu_share"]))

    rclpy.init()
    observer = rclpy.create_node("observer")
    observer.create_subscription(DiagnosticArray, "/sim_node/diagnostics", read, 10)
    values = {
        "scene": scene,
        "record_dir": folder / "runs",
        "topics": write_topics(folder, options.hz, options.all_outputs, not options.no_body_topics),
    }
    arguments: list[object] = ["--ros-args", "--log-level", "warn"]
    for name, value in values.items():
        arguments += ["-p", f"{name}:={value}"]
    node = start("rb_physics_nodes.sim_node", *arguments)
    peer = client(options, "single" if options.single else "batched")
    while peer.poll() is None and node.poll() is None:
        rclpy.spin_once(observer, timeout_sec=0.1)
    node.send_signal(signal.SIGINT)
    _, status, usage = os.wait4(node.pid, 0)
    node.returncode = os.waitstatus_to_exitcode(status)
    rclpy.try_shutdown()
    last["client"] = json.loads(peer.communicate()[0] or "{}")
    last["cpu_share"] = sum(shares[1:]) / max(1, len(shares[1:]))
    # Of the whole process, from its start to its end.
    cpu = usage.ru_utime + usage.ru_stime
    last["cpu_per_step_us"] = cpu / max(1, int(last["physics"]["step"])) * 1e6
    last["MB"] = sum(p.stat().st_size for p in (folder / "runs").glob("*/*.mcap")) / 1e6
    return last


def run_plain(options: argparse.Namespace, folder: Path, scene: Path) -> dict[str, Any]:
    """The plain node and the client."""
    node = start("benchmarks.plain_node", scene, options.seconds + SETTLE, options.hz, PUSHED,
                 folder / "plain.mcap")  # fmt: skip
    peer = client(options, "single")
    figures: dict[str, Any] = json.loads(node.communicate()[0] or "{}")
    figures["client"] = json.loads(peer.communicate()[0] or "{}")
    return figures


def tell(options: argparse.Namespace, own: dict[str, Any], plain: dict[str, Any] | None) -> None:
    """Print the figures side by side."""
    timing, inputs, log, seen = (own[key] for key in ("timing", "inputs", "log", "client"))
    period = 1e3 / options.hz
    rows = [
        ("steps lost", timing["lost_steps"], "lost_steps"),
        ("real-time factor", f"{float(timing['real_time_factor']):.3f}", "real_time_factor"),
        ("late at a wake-up, median", f"{float(timing['wake_error_p50_us']):.0f} us",
         "lateness_p50_us"),
        ("late at a wake-up, 99 %", f"{float(timing['wake_error_p99_us']):.0f} us",
         "lateness_p99_us"),
        ("wrench to pose, median", f"{seen['latency_p50_ms']:.2f} ms", "latency_p50_ms"),
        ("wrench to pose, 99 %", f"{seen['latency_p99_ms']:.2f} ms", "latency_p99_ms"),
        ("poses received", seen["poses"], "poses"),
        ("CPU, cores", f"{own['cpu_share']:.2f}", "cpu_share"),
        ("CPU per step", f"{own['cpu_per_step_us']:.0f} us", "cpu_per_step_us"),
    ]  # fmt: skip
    print(
        f"{options.bodies} bodies, {options.hz:g} Hz (period {period:g} ms), {options.seconds:g} s"
    )
    print(f"{'':28}{'sim_node':>14}{'plain rclpy node':>20}")
    flat = {**plain, **plain.get("client", {})} if plain else {}
    for label, value, key in rows:
        other = flat.get(key, "")
        other = f"{other:.3g}" if isinstance(other, float) else other
        print(f"{label:28}{value!s:>14}{other!s:>20}")
    print(f"wrenches sent {seen['messages_sent']} messages, accepted {inputs['accepted']}, refused "
          f"{inputs['refused']}, dropped {inputs['dropped']}")  # fmt: skip
    print(f"deadlines missed {timing['missed_deadlines']}; log {own['MB']:.1f} MB, dropped "
          f"{log.get('dropped')}")  # fmt: skip


def main() -> None:
    """Run both and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--bodies", type=int, default=100)
    parser.add_argument("--hz", type=float, default=1000.0, help="steps and poses per second")
    parser.add_argument("--wrenches", type=float, default=200.0, help="Hz, on each of 20 bodies")
    parser.add_argument("--single", action="store_true", help="a wrench topic for each body")
    parser.add_argument("--all-outputs", action="store_true", help="every topic at --hz")
    parser.add_argument("--no-body-topics", action="store_true", help="no topics of single bodies")
    parser.add_argument("--no-plain", action="store_true", help="without the plain node")
    options = parser.parse_args()
    use_own_domain()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = write_scene(folder, options.bodies, 1.0 / options.hz)
        own = run_node(options, folder, scene)
        plain = None if options.no_plain else run_plain(options, folder, scene)
    tell(options, own, plain)


if __name__ == "__main__":
    main()
