"""Which labels of a sequence file belong to which frames of a recording."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.labels.frame_names import names_of
from cable_tracker.sequences.labels.sequence_file import Label, read_labels
from cable_tracker.sequences.source_base import Source


def labels_by_frame(source: Source, truth: Path, allow_outside: bool) -> dict[int, CableState]:
    """Return the label of each labelled frame of a source, by the frame's number.

    Labels that are all of one file of another name are taken to be of this source.

    Raises
    ------
    RecordingError
        The labels cannot be read, a label belongs to no frame, or a second one to the same frame;
        the message names the line.
    """
    labels = read_labels(truth, allow_outside=allow_outside)
    names, count = names_of(source), source.frame_count
    frames = names.own_frames(labels, truth)
    files = {label.filename for label in labels}
    if not frames and len(files) == 1 and not any(map(names.lists, files)):
        frames = {str(label): label.frame for label in labels}
    names.need_any(frames.values(), truth)
    found: dict[int, Label] = {}
    for label in labels:
        if str(label) not in frames:
            continue
        number = frames[str(label)]
        if number is None:
            reason = f", which is no {names.what}"
        elif count is not None and number >= count:
            reason = f", but {source.path} has only {count} frames, counted from 0"
        elif number in found:
            reason = f" again, after line {found[number].line}; remove one of them"
        else:
            found[number] = label
            continue
        raise RecordingError(f"{truth}: line {label.line} labels {label}{reason}")
    return {number: label.state for number, label in found.items()}
