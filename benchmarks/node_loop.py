"""The node's loop: 1 kHz, 100 bodies, all outputs, logging on. Prints what was lost and how late.

``python -m benchmarks.node_loop [--seconds 20] [--rate 100] [--wrenches 0]``; run it on a quiet machine.
With ``--wrenches 200`` a second process sends that many wrenches a second to each of 20 bodies.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

from rb_physics.recording.topics import default_topics_path

PUSHED = 20  # bodies that get wrenches


def topics_at(rate: float, folder: Path) -> Path:
    """The packaged topics.yaml with every rate but that of the diagnostics set to `rate`."""
    table = yaml.safe_load(default_topics_path().read_text())
    for entry in table["topics"]:
        if "rate" in entry and entry["content"] != "diagnostics":
            entry["rate"] = rate
    path = folder / "topics.yaml"
    path.write_text(yaml.safe_dump(table))
    return path


def push(names: list[str], rate: float, seconds: float) -> None:
    """The second process: raw wrenches at absolute deadlines."""
    import rclpy
    from geometry_msgs.msg import WrenchStamped
    from rclpy.serialization import serialize_message

    rclpy.init()
    node = rclpy.create_node("pusher")
    message = WrenchStamped()
    message.header.frame_id = "world"
    message.wrench.force.x = 0.01
    data = serialize_message(message)
    publishers = [
        node.create_publisher(WrenchStamped, f"/sim_node/bodies/{name}/wrench", 10)
        for name in names
    ]
    while not all(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(0.01)
    due = time.monotonic()
    end = due + seconds
    while due < end:
        for publisher in publishers:
            publisher.publish(data)
        due += 1.0 / rate
        time.sleep(max(0.0, due - time.monotonic()))


def run(seconds: float, rate: float, wrenches: float) -> dict[str, dict[str, str]]:
    """Run the node once; returns its last diagnostics."""
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray

    import rb_physics as rb

    world = rb.load_scene("hundred_bodies").build()
    names = [body.name for body in world.bodies if body.type == "dynamic"]
    os.environ["ROS_DOMAIN_ID"] = str(100 + os.getpid() % 100)
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    last: dict[str, dict[str, str]] = {}

    def read(message: DiagnosticArray) -> None:
        for status in message.status:
            last[status.name] = {item.key: item.value for item in status.values}

    rclpy.init()
    observer = rclpy.create_node("observer")
    observer.create_subscription(DiagnosticArray, "/sim_node/diagnostics", read, 10)
    with tempfile.TemporaryDirectory() as folder:
        values = {
            "scene": "hundred_bodies",
            "record_dir": Path(folder) / "runs",
            "duration": float(seconds),
            "topics": topics_at(rate, Path(folder)),
        }
        arguments = [sys.executable, "-m", "rb_physics_nodes.sim_node", "--ros-args"]
        arguments += ["--log-level", "warn"]
        for name, value in values.items():
            arguments += ["-p", f"{name}:={value}"]
        node = subprocess.Popen(arguments)
        pusher = None
        if wrenches > 0:
            code = f"from benchmarks.node_loop import push; push({names[:PUSHED]}, {wrenches}, {seconds})"
            pusher = subprocess.Popen([sys.executable, "-c", code])
        while node.poll() is None:
            rclpy.spin_once(observer, timeout_sec=0.1)
        if pusher is not None:
            pusher.wait()
        for path in sorted((Path(folder) / "runs").glob("*/*.mcap")):
            last["log"] = {"MB": f"{path.stat().st_size / 1e6:.1f}"}
    rclpy.try_shutdown()
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    last["cpu"] = {"seconds": f"{usage.ru_utime + usage.ru_stime:.2f}"}
    return last


def main() -> None:
    """Print the figures of one run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--rate", type=float, default=100.0, help="Hz of every output")
    parser.add_argument(
        "--wrenches", type=float, default=0.0, help="per second and body, 20 bodies"
    )
    options = parser.parse_args()
    last = run(options.seconds, options.rate, options.wrenches)
    timing, inputs, log = (last[f"sim_node: {name}"] for name in ("timing", "inputs", "log"))
    print(f"100 bodies, 1 kHz, outputs at {options.rate:g} Hz, logging on, {options.seconds:g} s")
    print(f"  steps lost                {timing['lost_steps']}")
    print(f"  deadlines missed          {timing['missed_deadlines']}")
    print(
        f"  wake error p50 / p99      {timing['wake_error_p50_us']} / {timing['wake_error_p99_us']} us"
    )
    print(f"  real-time factor          {timing['real_time_factor']}")
    print(f"  CPU share of the node     {timing['cpu_share']} cores")
    print(f"  wrenches accepted         {inputs['accepted']} (refused {inputs['refused']})")
    print(f"  log                       dropped {log.get('dropped')}, {last['log']['MB']} MB")


if __name__ == "__main__":
    main()
