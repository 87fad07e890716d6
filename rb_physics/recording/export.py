"""Recordings for other tools: CSV, Parquet or NumPy files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import RecordingError
from .new_path import writing
from .tables import Tables, read_tables

FORMATS = ("csv", "parquet", "npz")
_LETTERS = {3: "xyz", 4: "xyzw"}


def export(recording: str | Path, directory: str | Path, format: str = "csv") -> list[Path]:
    """Writes poses, contact wrenches, contacts and totals into a new folder; the files made.

    Columns are SI units in world axes (wrenches: in the frame they were published in, which is a
    column); vectors become columns such as position_x. Bodies and topics appear by name (npz: as
    rows of `bodies` and `topics`). Raises RecordingError.
    """
    if format not in FORMATS:
        raise RecordingError(f"format {format!r} is not one of {', '.join(FORMATS)}")
    tables = read_tables(recording)
    directory = Path(directory)
    if directory.exists():
        raise RecordingError(f"{directory} exists already and is never overwritten")
    with writing(directory):
        directory.mkdir(parents=True)
        return _write(tables, directory, format)


def _write(tables: Tables, directory: Path, format: str) -> list[Path]:
    names = {"bodies": np.array(tables.bodies), "topics": np.array(tables.topics),
             "frames": np.array(tables.frames)}  # fmt: skip
    made = []
    for name in ("poses", "wrenches", "contacts", "totals"):
        table = getattr(tables, name)
        path = directory / f"{name}.{format}"
        if format == "npz":
            arrays: dict[str, Any] = names | {f: table[f] for f in table.dtype.names}
            np.savez_compressed(path, **arrays)
        else:
            columns = _columns(table, names)
            _write_csv(path, columns) if format == "csv" else _write_parquet(path, columns)
        made.append(path)
    return made


def _columns(table: NDArray, names: dict[str, NDArray]) -> dict[str, NDArray]:
    """Flat columns; bodies and topics by name; the two halves of a feature id joined."""
    columns: dict[str, NDArray] = {}
    for field in table.dtype.names or ():
        values = table[field]
        if field.startswith("body"):
            columns[field] = _named(names["bodies"], values)
        elif field == "topic":
            columns[field] = _named(names["topics"], values)
            columns["frame"] = _named(names["frames"], values)
        elif field == "feature":
            joined = np.ascontiguousarray(values, "<u4").view("<i8")
            columns[field] = joined.reshape(-1)
        elif values.ndim == 2:
            for i, letter in enumerate(_LETTERS[values.shape[1]]):
                columns[f"{field}_{letter}"] = values[:, i]
        else:
            columns[field] = values
    return columns


def _named(names: NDArray, rows: NDArray) -> NDArray:
    return names[rows] if len(rows) else np.empty(0, str)


def _write_csv(path: Path, columns: dict[str, NDArray]) -> None:
    import csv

    with open(path, "x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        # The shortest text that holds every bit: that of Python's numbers for doubles, NumPy's own for
        # single precision, which becomes 0.15000000596 otherwise.
        cells = (c.astype(str) if c.dtype == np.float32 else c for c in columns.values())
        writer.writerows(zip(*(column.tolist() for column in cells), strict=True))


def _write_parquet(path: Path, columns: dict[str, NDArray]) -> None:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise RecordingError("Parquet needs the pyarrow package: pip install pyarrow") from None
    table = pyarrow.table({name: pyarrow.array(column) for name, column in columns.items()})
    pyarrow.parquet.write_table(table, path)
