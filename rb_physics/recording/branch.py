"""Continuing a recorded run from any of its moments, as a recording of its own."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import decoders
from .errors import RecordingError
from .geometry import from_json as bodies_from_json
from .held_wrenches import HeldWrenches
from .initial_bodies import MATERIAL
from .log_reader import damage_told
from .operations import from_json as operation_from_json
from .recorded_run import Run
from .recorder import Recorder
from .repetition import Repetition


class AddedWrench(NamedTuple):
    """A wrench that the branch applies from its start on, beside what was recorded."""

    body: str
    force: tuple[float, float, float]  # N, world axes, at the centre of mass
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)  # N m, world axes


_SOURCE = 1_000_000  # of the first added wrench: far from the sources a node numbers from 0


def branch(
    recording: str | Path,
    directory: str | Path,
    start: float,
    until: float | None = None,
    *,
    wrenches: Sequence[AddedWrench] = (),
    rerun: str = "file",
    progress: Callable[[int, int, float], None] | None = None,
    **settings: Any,
) -> int:
    """Repeats `recording` up to `start`, then goes on and records into `directory`; the steps made.

    Up to the end of the recording its inputs are applied again as they were; behind it none are.

    Args:
        start, until: s of log time; until None: the end of the recording.
        wrenches, settings: what the branch does otherwise, e.g. ``impact_law="reflections"``.
        rerun: as in `Recorder`.
        progress: called with (steps done, steps in all, s per step).

    Raises RecordingError, SceneError.
    """
    run = Run(recording)
    dt = run.dt
    if settings.get("dt", dt) != dt:
        raise RecordingError("a branch keeps the step of its recording: dt can't be changed")
    longest = 1e6  # s, as for a run
    for name, value in (("start", start), ("until", until)):
        if value is not None and not abs(value) <= longest:
            raise RecordingError(f"{name} is {value:g} s; it must be a time up to {longest:g} s")
    first = round(start / dt) - run.first_step
    last = run.last_step if until is None else round(until / dt) - run.first_step
    if not 0 <= first <= run.last_step:
        raise RecordingError(
            f"start is {start:g} s; {run.log.directory} goes from {run.first_step * dt:g} to "
            f"{(run.first_step + run.last_step) * dt:g} s"
        )
    if last <= first:
        raise RecordingError(f"until must be later than start ({start:g} s)")
    repetition = Repetition(run)
    snapshot = max([0, *(step for step in run.snapshots if step <= first)])
    if snapshot > 0:
        repetition.skip_to(snapshot)
    while repetition.step < first:
        before = repetition.step
        hashes = repetition.advance(first)
        wrong = run.first_difference(before, hashes)
        if wrong is not None:
            raise RecordingError(
                f"{run.log.directory}: the repetition differs from step {wrong} on, "
                "so that there is nothing to part from: `rb_physics verify` tells what differs"
            )
        if repetition.diverged is not None:
            raise repetition.diverged
    _check(wrenches, repetition.world, start)
    scene = run.scene()
    world = scene.build(**(run.settings | settings))
    changes = _changes(world, repetition)
    if changes:
        world.step_count = repetition.world.step_count
    else:
        world.restore(repetition.world.save())
    with Recorder(
        world, directory, scene=scene, node_name=run.notes["node_name"], rerun=rerun,
        custom_data={"branch_of": run.log.directory.name, "branch_start": repr(start)},
        initial=run.initial, first=changes, log_start=run.first_step + first,
        held_wrenches=_held_wrenches(run, first),
    ) as recorder:  # fmt: skip
        for source, wrench in enumerate(wrenches, _SOURCE):
            recorder.perform("apply_wrench", body=wrench.body, force=wrench.force,
                             torque=wrench.torque, source=source)  # fmt: skip
        for span in run.lost:
            if snapshot <= (span.before or span.after) and span.after <= last:
                since, until = (
                    (run.first_step + step) * dt for step in (span.after, span.before or 0)
                )
                recorder.event(
                    "WARN",
                    f"inputs of {run.log.directory.name} from {since:g} to {until:g} s may be lost",
                )
        pending = repetition.pending()
        for step in range(first, last):
            while pending and pending[-1].step <= step:
                operation = pending.pop()
                recorder.perform(operation.name, **operation.arguments)
            world.step()
            recorder.after_step()
            if progress is not None:
                progress(step + 1 - first, last - first, dt)
            if recorder.error is not None:
                break
    if recorder.error is not None:
        raise RecordingError(f"the branch ended at {world.time:g} s: {recorder.error}")
    return last - first


def _check(wrenches: Sequence[AddedWrench], world: Any, start: float) -> None:
    """Before a folder is made: whether there is something to push."""
    for wrench in wrenches:
        pushable = [body.name for body in world.bodies if body.type == "dynamic"]
        if wrench.body not in pushable:
            raise RecordingError(
                f"at {start:g} s there is no dynamic body '{wrench.body}' to push; there are "
                f"{', '.join(pushable) or 'none'}"
            )
        if not np.isfinite([*wrench.force, *wrench.torque]).all():
            raise RecordingError(f"the wrench on body '{wrench.body}' must be finite")


def _held_wrenches(run: Run, first: int) -> str:
    """The wrenches that act when a branch begins with step `first`, which its log doesn't tell."""
    held, poses = HeldWrenches(), np.empty((0, 7))
    namespace = "/" + run.notes["node_name"].strip("/") + "/"
    names = ("bodies", "held_wrenches", "operations", "poses")
    with damage_told(run.log):
        for message in run.log.messages({namespace + name for name in names}, skip_damaged=True):
            kind = message.topic.removeprefix(namespace)
            if message.step > first:
                break
            if kind == "poses":
                poses = decoders.decode_pose_array(message.data)[2]
                continue
            text = decoders.decode_string(message.data)
            if kind == "bodies":
                held.set_bodies(bodies_from_json(text))
            elif kind == "held_wrenches":
                held.load(text)
            elif (operation := operation_from_json(text)).step < first:
                held.take(message.log_time, operation, poses)
    return held.to_json((run.first_step + first) * run.dt * 1e9)


def _changes(world: Any, repetition: Repetition) -> list[tuple[str, dict[str, Any]]]:
    """Operations that give a new world of the scene the bodies, surfaces and state of the branch's
    start; none where the bodies are those of the scene.
    """
    now, added = repetition.world, repetition.added
    changes: list[tuple[str, dict[str, Any]]] = []
    for body in world.bodies:
        if body.name in added or body.name not in now:
            changes.append(("remove_body", {"body": body.name}))
    changes += [("add_body", {"description": description}) for description in added.values()]
    for body in now.bodies:
        surface = {name: getattr(body, name) for name in MATERIAL}
        known = world[body.name] if body.name in world and body.name not in added else None
        if known is None or surface != {name: getattr(known, name) for name in MATERIAL}:
            changes.append(("change_body", {"body": body.name, **surface}))
    if changes:
        changes.append(("restore", {"snapshot": base64.b64encode(now.save()).decode()}))
    return changes
