"""What a recording holds, for people."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import numpy as np

from . import decoders
from .errors import RecordingError
from .log_reader import Recording, damage_told
from .lost_spans import from_json as lost_from_json
from .lost_spans import merged
from .outputs import TOTALS
from .topics import CONTENT


def summary(recording: str | Path) -> str:
    """Several lines of text. Raises RecordingError when it isn't a recording."""
    log = Recording(recording)
    with damage_told(log):
        return _summary(log)


def _summary(log: Recording) -> str:
    notes = log.custom_data
    namespace = "/" + notes.get("node_name", "sim_node").strip("/") + "/"
    counts: dict[str, int] = defaultdict(int)
    sizes: dict[str, int] = defaultdict(int)
    types: dict[str, str] = {}
    first: int | None = None
    last = steps = 0
    totals: list[list[float]] = []
    names: list[str] = []
    events: list[tuple[int, str]] = []
    snapshots = 0
    for message in log.messages():
        counts[message.topic] += 1
        sizes[message.topic] += len(message.data)
        types[message.topic] = message.type
        first = message.log_time if first is None else first
        last, steps = max(last, message.log_time), max(steps, message.step)
        if message.topic == namespace + "totals":
            totals.append(decoders.decode_multi_array(message.data, "f8")[1].tolist())
        elif message.topic == namespace + "body_names":
            names = list(decoders.decode_json_list(message.data))
        elif message.topic == namespace + "events" and len(events) < 20:
            events.append((message.log_time, decoders.decode_string(message.data)))
        elif message.topic == namespace + "snapshots":
            snapshots += 1
    if not counts:
        raise RecordingError(f"{log.directory} holds no messages: it is empty or damaged")
    lines = [f"recording   {log.directory}"]
    lines.extend(f"damaged     {text}" for text in _damage(log, notes))
    state = "finished" if not log.torn else "torn off: `rb_physics recover` makes a whole copy"
    stopped = notes.get("stopped")
    lines.append(f"state       {state}" + (f", stopped early: {stopped}" if stopped else ""))
    lines.append(f"scene       {notes.get('scene') or 'not stored'}")
    start = (first or 0) * 1e-9
    lines.append(
        f"time        {start:.3f} to {last * 1e-9:.3f} s, {steps} steps of "
        f"{notes.get('dt', '?')} s, {snapshots} snapshots"
    )
    lines.append(f"bodies      {len(names)}: {_shortened(names)}")
    lines.append(
        f"made        {notes.get('created', '?')} by rb_physics {notes.get('rb_physics', '?')}, "
        f"format {notes.get('format_version', '?')}, on {notes.get('cpu', '?')}"
    )
    if totals:
        lines.extend(_physics(np.array(totals), _worst_steps(notes)))
    size = sum(path.stat().st_size for path in log.files)
    dropped = notes.get("dropped", "unknown")
    lines.append(
        f"messages    {sum(counts.values())} in {len(log.files)} file(s), {_bytes(size)} on disk, "
        f"{dropped} dropped"
    )
    lines.append("topics")
    groups = {
        name + (f" ({len(group)} topics)" if len(group) > 1 else ""): group
        for name, group in _grouped(counts, namespace).items()
    }
    width = max(map(len, groups))
    for label, group in groups.items():
        total = sum(counts[topic] for topic in group)
        payload = sum(sizes[topic] for topic in group)
        lines.append(f"  {label:<{width}} {total:>9}  {_bytes(payload):>9}  {types[group[0]]}")
    if events:
        lines.append("events")
        lines.extend(f"  {time * 1e-9:9.3f} s  {text}" for time, text in events)
    return "\n".join(lines)


def _damage(log: Recording, notes: dict[str, str]) -> list[str]:
    """What is damaged here, or was when the recording was recovered."""
    told = [
        f"attachment {name}: its checksum is wrong"
        for name in dict.fromkeys(log.damaged_attachments)
    ]
    if notes.get("damaged_attachments"):
        told.append(f"lost when recovered: {notes['damaged_attachments']}")
    for span in merged(lost_from_json(notes.get("lost_steps", "[]"))):
        told.append(f"messages between steps {span.after} and {span.before} are lost")
    return told


def _worst_steps(notes: dict[str, str]) -> list[float] | None:
    """Largest residual, penetration and number of contacts over all steps; None in older and torn
    bags."""
    try:
        residual, penetration, contacts = json.loads(notes["worst_steps"])
        return [float(residual), float(penetration), float(contacts)]
    except (KeyError, TypeError, ValueError):
        return None


def _physics(totals: np.ndarray, worst: list[float] | None) -> list[str]:
    column = {name: totals[:, i] for i, name in enumerate(TOTALS)}
    energy = column["kinetic_energy"] + column["potential_energy"]
    if worst is None:
        worst = [column[name].max() for name in ("residual", "max_penetration", "contacts")]
    return [
        f"energy      {energy[0]:.6g} J at the start, {energy[-1]:.6g} J at the end",
        f"solver      residual up to {worst[0]:.1e}, penetration up to {worst[1]:.1e} m, up to "
        f"{int(worst[2])} contacts",
    ]


def _shortened(names: list[str], most: int = 8) -> str:
    shown = ", ".join(names[:most])
    return shown + (f" and {len(names) - most} more" if len(names) > most else "")


def _grouped(counts: dict[str, int], namespace: str) -> dict[str, list[str]]:
    """Per-body topics under one name, NAME standing for the body."""
    per_body = {"pose", "odom", "contact_wrench", "wrench", "cmd_pose", "cmd_vel", *CONTENT}
    groups: dict[str, list[str]] = defaultdict(list)
    for topic in counts:
        parts = topic.removeprefix(namespace).split("/")
        if len(parts) >= 3 and parts[0] == "bodies" and parts[2] in per_body:
            groups[namespace + "/".join(["bodies", "NAME", *parts[2:]])].append(topic)
        else:
            groups[topic].append(topic)
    return groups


def _bytes(size: float) -> str:
    for unit in ("B", "kB", "MB"):
        if size < 1000:
            return f"{size:.0f} {unit}" if unit == "B" else f"{size:.1f} {unit}"
        size /= 1000
    return f"{size:.1f} GB"
