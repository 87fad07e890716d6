"""`sim_node`: the simulator as a ROS 2 node. Run with `sim_node --ros-args -p scene:=demo`."""

from __future__ import annotations

import gc
import signal
import sys
import threading
from collections.abc import Sequence

from .start import StartError, import_rclpy, one_line

NAME = "sim_node"
CALLS_AT_ONCE = 3  # service calls answered side by side; a long ~/step takes one of them
SWITCH_INTERVAL = 1e-4  # s; Python's 5 ms would make the physics thread miss its deadlines


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT, SIGTERM or the end of its duration. Returns the exit code."""
    try:
        return _run(arguments)
    except StartError as error:
        print(f"sim_node: {error}", file=sys.stderr)
        return 2


def _run(arguments: Sequence[str] | None) -> int:
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    rclpy = import_rclpy()
    from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
    from rclpy.signals import SignalHandlerOptions

    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common class for what can go wrong here
        raise StartError(f"ROS 2 does not start: {one_line(error)}") from None
    try:
        from .simulator import Simulator

        node = rclpy.create_node(NAME)
        simulator = Simulator(node)
    except (StartError, ValueError, OSError, ImportError) as error:
        rclpy.try_shutdown()
        raise StartError(one_line(error)) from None

    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.freeze()  # what lives as long as the node need not be looked at by the collector
    executor = MultiThreadedExecutor(num_threads=CALLS_AT_ONCE)
    executor.add_node(node)

    broken: list[BaseException] = []

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except BaseException as error:  # reported by the main thread, which ends the process
            broken.append(error)
            stop.set()

    spinning = threading.Thread(target=spin, name="executor", daemon=True)
    spinning.start()
    simulator.start()
    try:
        while not stop.is_set() and not simulator.loop.finished.wait(0.1):
            pass
    finally:
        error = simulator.stop()
        executor.shutdown(timeout_sec=2.0)
        spinning.join(timeout=2.0)
        rclpy.try_shutdown()
    error = error or (broken[0] if broken else None)
    if error is not None:
        print(f"sim_node: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
