"""Labels that are not saved yet, kept beside the label file in case that the process dies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from cable_tracker.atomic_output import write_text
from cable_tracker.cable.model.state import POSE_SYMBOLS, CableState
from cable_tracker.errors import RecordingError
from cable_tracker.gui.labelling.csv_rows import read_rows
from cable_tracker.gui.labelling.labels import NO_CABLE, FrameLabel, Labels, flagged_label
from cable_tracker.sequences.labels.frame_names import FrameNames
from cable_tracker.sequences.labels.sequence_file import FrameName, parse_name
from cable_tracker.sequences.tables.csv_tables import csv_text

HEADER = ("frame", "stamp", "flag", *POSE_SYMBOLS, "file")
SUFFIX = ".autosave"


def autosave_path(path: Path) -> Path:
    """Return where the unsaved labels of a label file lie: ``NAME.autosave``."""
    return path.with_name(path.name + SUFFIX)


def write_autosave(path: Path, labels: Labels, names: FrameNames) -> None:
    """Write labels; numbers read back are equal to the last bit.

    Parameters
    ----------
    names : FrameNames
        Names of the frames, by which they are found again.

    Raises
    ------
    OSError, ValueError
        They cannot be written; what lay there is as it was.
    """
    folder = path.absolute().parent
    rows = (
        (
            frame,
            label.stamp,
            label.flag,
            *_places(label),
            names.name(frame, folder),
        )
        for frame, label in sorted(labels.items())
    )
    write_text(path, csv_text(HEADER, rows), waits=False)


def _places(label: FrameLabel) -> Iterator[str]:
    state = label.state
    if state is None:
        return iter(("", "", "", ""))
    return map(repr, (state.distance, state.angle, state.width, state.skew))


def read_autosave(path: Path, names: FrameNames) -> dict[int, FrameLabel]:
    """Read what `write_autosave` wrote.

    Frames are found by their names, as those of a label file: pictures may have come or gone since.
    Labels of frames that are gone are left out.

    Raises
    ------
    RecordingError
        The file cannot be read, a line is malformed, or it labels other recordings only; the
        message names it.
    """
    rows = read_rows(path, HEADER, _parse)
    try:
        frames = names.frames([name for _, name in rows], path)
    except RecordingError as error:
        raise RecordingError(
            f"{path}: holds unsaved labels, but not of this recording; move it away, or remove it"
        ) from error
    return {
        frame: label for frame, (label, _) in zip(frames, rows, strict=True) if frame is not None
    }


def _parse(fields: list[str]) -> tuple[FrameLabel, FrameName]:
    _, stamp, flag, *places, name = fields
    state = None if flag == NO_CABLE else _state(places)
    return flagged_label(state, flag, int(stamp) if stamp else None), parse_name(name)


def _state(places: list[str]) -> CableState:
    distance, angle, width, skew = map(float, places)
    state = CableState(distance, angle, width, skew)
    if not state.is_finite():
        raise ValueError("a number is not finite")
    return state
