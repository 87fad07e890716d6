"""`make demo`: the whole way through, between real processes.

Starts sim_node with the packaged scene "demo" and, as a second process, an example node that
pushes the ball into the tower through a topic. This process listens in, says what happened, and
exits with 0 only if the forces, the log and the processes were as they must be.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import time
from pathlib import Path

from .demo_report import Report
from .own_domain import use_own_domain

TOWER = "box_"
START, DURATION, PUSH = 3.0, 10.0, 0.8  # simulated s: the push begins, the run ends, push lasts
FORCE = 60.0  # N on the ball
PATIENCE = 60.0  # s of wall time until the node is there, and without a step before giving up


def main(arguments: list[str] | None = None) -> int:
    """Run the demo; returns the exit code."""
    parser = argparse.ArgumentParser(prog="rb_physics_nodes.demo", description=__doc__)
    parser.add_argument("--record-dir", default="recordings", help="parent folder of the recording")
    parser.add_argument("--no-rerun", action="store_true", help="record the bag only")
    options = parser.parse_args(arguments)
    use_own_domain()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends like Ctrl-C
    before = set(_runs(options.record_dir))
    print("starting sim_node and, as a second process, the example node pusher")
    node = _start(
        "rb_physics_nodes.sim_node",
        scene="demo",
        record_dir=options.record_dir,
        rerun="'off'" if options.no_rerun else "file",
        duration=DURATION,
        start_paused="true",
    )
    pusher = _start(
        "rb_physics_nodes.examples.pusher",
        topic="/sim_node/bodies/ball/wrench",
        frame="world",
        force=f"[{FORCE}, 0.0, 0.0]",
        start=START,
        duration=PUSH,
    )
    try:
        report = _watch(node)
        code = node.wait(PATIENCE)
    except (TimeoutError, subprocess.TimeoutExpired, KeyboardInterrupt) as error:
        print(f"the demo ended early: {error or type(error).__name__}", file=sys.stderr)
        return 1
    finally:
        for process in (pusher, node):
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in (pusher, node):
            try:
                process.wait(20.0)
            except subprocess.TimeoutExpired:
                process.kill()
    if report is None:
        print(f"sim_node ended with exit code {code} before the simulation began", file=sys.stderr)
        return 1
    failures = report.tell(START, DURATION)
    if code != 0:
        failures.append(f"sim_node ended with exit code {code}")
    failures += _tell_recording(options.record_dir, before, with_rerun=not options.no_rerun)
    for failure in failures:
        print(f"NOT as it should be: {failure}", file=sys.stderr)
    return 1 if failures else 0


def _start(module: str, **parameters: object) -> subprocess.Popen[bytes]:
    arguments = [sys.executable, "-m", module, "--ros-args", "--log-level", "warn"]
    for name, value in parameters.items():
        arguments += ["-p", f"{name}:={value}"]
    return subprocess.Popen(arguments)


def _watch(node: subprocess.Popen[bytes]) -> Report | None:
    """Listen until the simulated time is over or the node ends."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from std_srvs.srv import SetBool
    from tqdm import tqdm

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    observer = rclpy.create_node("demo_observer")
    report = Report(observer, TOWER)
    pause = observer.create_client(SetBool, "/sim_node/pause")
    topic = "/sim_node/bodies/ball/wrench"
    try:
        end = time.monotonic() + PATIENCE
        while not (
            report.connected
            and pause.service_is_ready()
            and observer.count_publishers(topic) > 0
            and observer.count_subscribers(topic) > 0
        ):
            if node.poll() is not None:
                return None
            if time.monotonic() > end:
                raise TimeoutError(f"the nodes did not find each other within {PATIENCE:g} s")
            rclpy.spin_once(observer, timeout_sec=0.05)
        pause.call_async(SetBool.Request(data=False))
        end = time.monotonic() + PATIENCE
        with tqdm(total=DURATION, unit="s", desc="simulated", file=sys.stdout, ncols=79,
                  mininterval=0.5, bar_format="{desc} {n:4.1f} of {total:.0f} s |{bar}|") as bar:  # fmt: skip
            while report.time < DURATION - 1e-9:
                rclpy.spin_once(observer, timeout_sec=0.05)
                if report.time > bar.n:
                    bar.update(report.time - bar.n)
                    end = time.monotonic() + PATIENCE
                if node.poll() is not None:
                    break
                if time.monotonic() > end:
                    raise TimeoutError(f"no step within {PATIENCE:g} s")
        while node.poll() is None and not report.finished and time.monotonic() < end:
            rclpy.spin_once(observer, timeout_sec=0.05)
        return report
    finally:
        rclpy.try_shutdown()


def _runs(parent: str) -> list[Path]:
    return [path for path in Path(parent).glob("*") if path.is_dir()]


def _tell_recording(parent: str, before: set[Path], with_rerun: bool) -> list[str]:
    new = sorted(set(_runs(parent)) - before)
    if not new:
        return [f"there is no new recording in {parent}"]
    wanted = ["metadata.yaml", "*.mcap", *(["*.rrd"] if with_rerun else [])]
    print(f"recording:                {new[-1]}")
    failures = []
    for pattern in wanted:
        files = sorted(new[-1].glob(pattern))
        if not files or not all(file.stat().st_size for file in files):
            failures.append(f"{new[-1]} has no {pattern}")
        for file in files:
            print(f"  {file.name:<24}{file.stat().st_size / 1e6:8.2f} MB")
    print(f"look at it with           rb_physics view {new[-1]}")
    return failures


if __name__ == "__main__":
    sys.exit(main())
