"""`frames.parquet`: what the tracker and the smoother say of each frame."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.model.state import POSE_SYMBOLS
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import AGAIN, STATUSES
from cable_tracker.survey.routes.route import Course
from cable_tracker.survey.trajectory import poses_of_rows

FRAMES = "frames.parquet"
"""Name of the file."""

PLAIN = (
    "frame", "stamp", "presence", *POSE_SYMBOLS, "offset", "heading",
    "sigma_offset", "sigma_heading", "diameter", "altitude",
)  # fmt: skip
"""Columns that are written as they are [px, rad, m, ns]."""

UNITS = {
    "stamp": "ns", "d": "px", "alpha": "rad", "w": "px", "beta": "rad", "offset": "m",
    "heading": "rad", "sigma_offset": "m", "sigma_heading": "rad", "diameter": "m",
    "altitude": "m", "x": "m", "y": "m", "yaw": "rad", "smoothed_aside": "m",
    "smoothed_heading": "rad", "smoothed_sigma": "m", "along": "m",
}  # fmt: skip

ROW_GROUP = 4096
"""Rows that are written together."""


def write_frames(path: Path, recording: str, dive: ForwardDive, course: Course | None) -> None:
    """Write the table of a dive, some rows at a time."""
    count = len(dive.table)
    all_poses = (
        None if course is None else poses_of_rows(dive.table.rows, course.trajectory, dive.disk)
    )
    with ExitStack() as stack:
        writer: pq.ParquetWriter | None = None
        for first in range(0, max(count, 1), ROW_GROUP):
            part = slice(first, min(first + ROW_GROUP, count))
            table = _table(recording, dive, course, all_poses, part)
            if writer is None:
                writer = stack.enter_context(
                    pq.ParquetWriter(path, table.schema, compression="zstd")
                )
            writer.write_table(table)
            dive.disk.release_pages()


def _table(
    recording: str,
    dive: ForwardDive,
    course: Course | None,
    all_poses: FloatArray | None,
    part: slice,
) -> pa.Table:
    """Return some rows of the table; `all_poses` (N, 3) are those of the vehicle in all of them."""
    rows = dive.table.rows[part]
    count = len(rows)
    columns: dict[str, pa.Array] = {
        "recording": pa.array([recording] * count, pa.string()),
        "status": _words(rows["status"], STATUSES),
    }
    for name in PLAIN:
        columns[name] = pa.array(rows[name], from_pandas=rows[name].dtype.kind == "f")
    columns["no_metres"] = _words(rows["reason"], dive.table.reasons)
    columns["again"] = _words(rows["again"], AGAIN)
    poses, smoothed = np.full((count, 3), np.nan), np.full((count, 4), np.nan)
    if course is not None and all_poses is not None:
        poses = all_poses[part]
        cable, keyframe = course.cable, course.keyframes.of_rows(part)
        known = (keyframe >= 0) & np.isfinite(poses).all(axis=1)
        keyframe = keyframe[known]
        sigma = np.sqrt(cable.covariances[keyframe, 0, 0])
        smoothed[known] = np.column_stack(
            (cable.states[keyframe, :2], sigma, cable.along[keyframe])
        )
    for name, column in zip(("x", "y", "yaw"), poses.T, strict=True):
        columns[name] = pa.array(column, from_pandas=True)
    names = ("smoothed_aside", "smoothed_heading", "smoothed_sigma", "along")
    for name, column in zip(names, smoothed.T, strict=True):
        columns[name] = pa.array(column, from_pandas=True)
    fields = [
        pa.field(name, column.type, metadata={"unit": UNITS[name]} if name in UNITS else None)
        for name, column in columns.items()
    ]
    return pa.Table.from_arrays(list(columns.values()), schema=pa.schema(fields))


def _words(numbers: IndexArray, words: Sequence[str]) -> pa.Array:
    """Return the words that rows have by their numbers in a list."""
    return pa.array(words, pa.string()).take(pa.array(numbers))


def check_frames(path: Path) -> None:
    """Read a table that `write_frames` has written, to see that it is whole.

    Raises
    ------
    OSError, ValueError
        It is not there, or damaged.
    """
    try:
        with pq.ParquetFile(path) as file:
            for number in range(file.num_row_groups):
                file.read_row_group(number)
    # Some of these are neither.
    except pa.ArrowException as error:
        raise ValueError(str(error)) from error


def join_frames(parts: list[Path], path: Path) -> None:
    """Put the tables of several dives into one file, a row group at a time."""
    with ExitStack() as stack:
        writer: pq.ParquetWriter | None = None
        for part in parts:
            with pq.ParquetFile(part) as file:
                if writer is None:
                    writer = stack.enter_context(
                        pq.ParquetWriter(path, file.schema_arrow, compression="zstd")
                    )
                for number in range(file.num_row_groups):
                    writer.write_table(file.read_row_group(number))
