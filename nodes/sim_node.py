"""`sim_node`: the simulator as a ROS 2 node. Run with `sim_node --ros-args -p scene:=demo`."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Sequence

from .start import (
    SIGNALS,
    StartError,
    check_arguments,
    ignore_signals,
    import_rclpy,
    one_line,
)

NAME = "sim_node"
CALLS_AT_ONCE = 3  # service calls answered side by side; a long ~/step takes one of them
LOOK = 0.02  # s between looks at the request to stop
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
    for number in SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    rclpy = import_rclpy()
    check_arguments(arguments)
    from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
    from rclpy.signals import SignalHandlerOptions

    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy has no common class for what can go wrong here
        raise StartError(f"ROS 2 does not start: {one_line(error)}") from None
    try:
        from rclpy.lifecycle import TransitionCallbackReturn

        from .lifecycle import SimNode
        from .simulator import StuckError

        node = SimNode(NAME)
        autostart = node.get_parameter("autostart").value
        if autostart and node.trigger_configure() != TransitionCallbackReturn.SUCCESS:
            raise ValueError(one_line(node.error or ValueError("the node could not be configured")))
    except (ValueError, OSError, ImportError) as error:
        rclpy.try_shutdown()
        raise StartError(one_line(error)) from None

    sys.setswitchinterval(SWITCH_INTERVAL)
    gc.freeze()  # what lives as long as the node need not be looked at by the collector
    executor = MultiThreadedExecutor(num_threads=CALLS_AT_ONCE)
    executor.add_node(node)

    broken: list[BaseException] = []
    ending = threading.Event()

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        except BaseException as error:  # reported by the main thread, which ends the process
            if not ending.is_set():  # rclpy takes its own parts away while it still uses them
                broken.append(error)
                stop.set()

    spinning = threading.Thread(target=spin, name="executor", daemon=True)
    try:
        if autostart:  # before calls are answered: none should find the node inactive
            node.trigger_activate()
        spinning.start()
        while not stop.is_set() and not node.finished:
            time.sleep(LOOK)
    finally:
        ending.set()  # first: closing takes parts away under the executor
        node.close()
        executor.shutdown(timeout_sec=2.0)
        if spinning.ident is not None:
            spinning.join(timeout=2.0)
        rclpy.try_shutdown()
        ignore_signals()
    error = node.error or (broken[0] if broken else None)
    if error is not None:
        print(f"sim_node: {error}", file=sys.stderr, flush=True)
        if isinstance(error, StuckError):
            os._exit(1)  # there is no other way to end a thread
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
