"""What the node adds to ~/diagnostics: timing, inputs, the log."""

from __future__ import annotations

import time
from typing import Any

from rb_physics.recording import Recorder

from .inputs import Inputs
from .pacer import Pacer

OK, WARN, ERROR = 0, 1, 2
Status = tuple[int, str, str, str, dict[str, object]]


class Diagnostics:
    """Statuses as the recorder's outputs take them; called in the physics thread."""

    def __init__(self, world: Any, inputs: Inputs, pacer: Pacer, recorder: Recorder) -> None:
        self._world = world
        self._inputs = inputs
        self._pacer = pacer
        self._recorder = recorder
        self._last = (time.monotonic(), 0.0, time.process_time())
        self._seen = (0, 0)

    def __call__(self) -> list[Status]:
        return [self._timing(), self._messages(), self._log()]

    def _timing(self) -> Status:
        now, sim, cpu = time.monotonic(), float(self._world.time), time.process_time()
        last_now, last_sim, last_cpu = self._last
        self._last = (now, sim, cpu)
        span = max(now - last_now, 1e-9)
        p50, p99 = self._pacer.wake_error_percentiles()
        pacer = self._pacer
        behind = pacer.lost_steps > self._seen[0]
        self._seen = (pacer.lost_steps, self._seen[1])
        text = "the simulation does not keep up with real time" if behind else "as asked for"
        values: dict[str, object] = {
            "real_time_factor": (sim - last_sim) / span,
            "real_time_factor_asked": pacer.factor,
            "missed_deadlines": pacer.missed_deadlines,
            "lost_steps": pacer.lost_steps,
            "wake_error_p50_us": p50 * 1e6,
            "wake_error_p99_us": p99 * 1e6,
            "cpu_share": (cpu - last_cpu) / span,
        }
        return (WARN if behind else OK), "sim_node: timing", text, "", values

    def _messages(self) -> Status:
        counters, inbox = self._inputs.counters, self._inputs.inbox
        trouble = counters["refused"] + inbox.dropped
        new = trouble > self._seen[1]
        self._seen = (self._seen[0], trouble)
        values: dict[str, object] = {
            "received": inbox.received,
            "accepted": counters["accepted"],
            "refused": counters["refused"],
            "refused_frame": counters["refused_frame"],
            "refused_value": counters["refused_value"],
            "refused_malformed": counters["refused_malformed"],
            "refused_stamp": counters["refused_stamp"],
            "refused_body": counters["refused_body"],
            "ignored": counters["ignored"],
            "dropped": inbox.dropped,
            "discarded_by_reset": counters["discarded_by_reset"],
            "discarded_by_removal": counters["discarded_by_removal"],
            "active_wrenches": self._inputs.wrenches.active(int(self._world.step_count)),
        }
        text = "messages were refused" if new else "all messages accepted"
        return (WARN if new else OK), "sim_node: inputs", text, "", values

    def _log(self) -> Status:
        error = self._recorder.error
        values: dict[str, object] = dict(self._recorder.counters)
        if error is not None:
            return ERROR, "sim_node: log", str(error), "", values
        if self._recorder.view_error is not None:
            return WARN, "sim_node: log", self._recorder.view_error, "", values
        directory = self._recorder.directory
        text = f"recording to {directory}" if directory is not None else "not recording"
        return OK, "sim_node: log", text, "", values
