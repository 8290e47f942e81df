"""Labels that are not saved yet, kept beside the label file in case that the process dies."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from pathlib import Path

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError, one_line
from cable_tracker.gui.labelling.label_file import write_atomically
from cable_tracker.gui.labelling.labels import NO_CABLE, FrameLabel, Labels, flagged_label
from cable_tracker.sequences.csv_tables import csv_text

HEADER = ("frame", "stamp", "flag", "d", "alpha", "w", "beta")
SUFFIX = ".autosave"


def autosave_path(path: Path) -> Path:
    """Return where the unsaved labels of a label file lie: ``NAME.autosave``."""
    return path.with_name(path.name + SUFFIX)


def write_autosave(path: Path, labels: Labels, stamps: Mapping[int, int]) -> None:
    """Write labels; numbers read back are equal to the last bit.

    Raises
    ------
    OSError
        They cannot be written; what lay there is as it was.
    """
    rows = (
        (frame, stamps.get(frame, ""), label.flag, *_places(label))
        for frame, label in sorted(labels.items())
    )
    write_atomically(path, csv_text(HEADER, rows), waits=False)


def _places(label: FrameLabel) -> Iterator[str]:
    state = label.state
    if state is None:
        return iter(("", "", "", ""))
    return map(repr, (state.distance, state.angle, state.width, state.skew))


def read_autosave(path: Path) -> tuple[dict[int, FrameLabel], dict[int, int]]:
    """Read what `write_autosave` wrote.

    Returns
    -------
    dict, dict
        Labels and times [ns] by frame.

    Raises
    ------
    RecordingError
        The file cannot be read, or a line is malformed; the message names it.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(
            f"{path}: cannot be read ({one_line(error)}); check or remove the file"
        ) from error
    if not rows or tuple(rows[0]) != HEADER:
        raise RecordingError(
            f"{path}: line 1 is not the header {','.join(HEADER)}; remove the file"
        )
    labels, stamps = {}, {}
    for line, row in enumerate(rows[1:], start=2):
        try:
            frame, stamp, flag, *places = row
            state = None if flag == NO_CABLE else _state(places)
            number = int(frame)
            if number < 0:
                raise ValueError(f"there is no frame {frame}")
            labels[number] = flagged_label(state, flag)
            if stamp:
                stamps[number] = int(stamp)
        except ValueError as error:
            raise RecordingError(
                f"{path}: line {line} is malformed ({one_line(error)}); correct it, or remove"
                " the file"
            ) from error
    return labels, stamps


def _state(places: list[str]) -> CableState:
    distance, angle, width, skew = map(float, places)
    state = CableState(distance, angle, width, skew)
    if not state.is_finite():
        raise ValueError("a number is not finite")
    return state
