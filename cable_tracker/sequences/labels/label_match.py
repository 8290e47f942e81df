"""Which labels of a sequence file belong to which frames of a recording."""

from __future__ import annotations

import os.path
from collections.abc import Sequence
from pathlib import Path, PurePath

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.labels.sequence_file import Label, SequenceFileSource, read_labels
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.source_base import Source

_IN_ANOTHER, _MAY_BE_IN_FOLDER, _IN_FOLDER = range(3)
"""How surely a labelled file lies in a folder, see `_nearness`."""


def labels_by_frame(source: Source, truth: Path, allow_outside: bool) -> dict[int, CableState]:
    """Return the label of each labelled frame of a source, by the frame's number.

    Raises
    ------
    RecordingError
        The labels cannot be read, a label belongs to no frame, or a second one to the same frame;
        the message names the line.
    """
    labels = read_labels(truth, allow_outside=allow_outside)
    _check_labels(source, labels, truth)
    found: dict[int, Label] = {}
    if isinstance(source, ImageFolderSource):
        found = _picture_labels(source, labels, truth)
    elif isinstance(source, SequenceFileSource):
        found = _entry_labels(source, labels)
    if not found:
        found = _numbered_labels(source, _labels_of(source, labels, truth), truth)
    return {number: label.state for number, label in found.items()}


def plain_path(path: Path) -> Path:
    """Return an absolute path without ``..``; links are followed only where there is one.

    A recording that is named ``.`` has its name there.
    """
    absolute = path.absolute()
    return absolute.resolve() if ".." in absolute.parts else absolute


def _check_labels(source: Source, labels: list[Label], truth: Path) -> None:
    """See that every label belongs to a frame of the source, and no frame has two.

    Raises
    ------
    RecordingError
        A label does not; the message names its line.
    """
    path = plain_path(source.path)
    folder = path if isinstance(source, ImageFolderSource) else path.parent
    near = {label.line for label in labels_near(labels, truth, folder)}
    own = {label.filename for label in labels if Path(label.filename).name == path.name}
    pictures = (
        {picture.name for picture in source.pictures}
        if isinstance(source, ImageFolderSource)
        else None
    )
    first_line: dict[str, int] = {}
    for label in labels:
        name = str(label)
        if name in first_line:
            raise RecordingError(
                f"{truth}: line {label.line} labels {name} again, after line {first_line[name]};"
                " remove one of them"
            )
        first_line[name] = label.line
        if label.line not in near or (own and label.filename not in own):
            continue
        reason = _mismatch(source, label, pictures)
        if reason:
            raise RecordingError(f"{truth}: line {label.line} labels {name}, but {reason}")


def _mismatch(source: Source, label: Label, pictures: set[str] | None) -> str:
    """Return why a label belongs to no frame; empty if it does, or if that cannot be told.

    `pictures` are the names of those in a folder; None: the source is none.
    """
    name, count = plain_path(source.path).name, source.frame_count
    if isinstance(source, SequenceFileSource):
        return ""
    if pictures is not None and label.frame is None:
        known = PurePath(label.filename).name in pictures
        return "" if known else f"{name} holds no such picture"
    if label.frame is None:
        return f"a frame of {name} goes by its number: FILE:FRAME"
    if count is not None and label.frame >= count:
        return f"{name} has only {count} frames, counted from 0"
    return ""


def _own_labels(labels: list[Label], truth: Path, folder: Path) -> list[Label]:
    """Return the labels of files in a folder, of labels that are called like such files.

    A label names its file relative to the folder of the label file, or to another one if either
    has been moved. Where the same names come in several folders, those of the nearest count.

    Raises
    ------
    RecordingError
        Two labelled files have one name, and nothing tells which of them is meant.
    """
    candidates: dict[str, dict[int, list[Label]]] = {}
    for label in labels_near(labels, truth, folder):
        name = PurePath(label.filename)
        by_nearness = candidates.setdefault(name.name, {})
        by_nearness.setdefault(_nearness(name.parent, truth, folder), []).append(label)
    own: list[Label] = []
    for by_nearness in candidates.values():
        nearest = max(by_nearness)
        names = sorted({label.filename for label in by_nearness[nearest]})
        if nearest < _IN_FOLDER and len(names) > 1:
            raise RecordingError(
                f"{truth}: labels {names[0]} and {names[1]}, either of which may be that of"
                f" {folder}; give a file with labels of one folder"
            )
        own += by_nearness[nearest]
    return own


def labels_near(labels: Sequence[Label], truth: Path, folder: Path) -> list[Label]:
    """Return the labels of a file that may be of a folder: all of them if none seems to be.

    Those of another folder are left out where others are of this one.
    """
    parents = {PurePath(label.filename).parent for label in labels}
    near = {parent: _nearness(parent, truth, folder) for parent in parents}
    least = min(_MAY_BE_IN_FOLDER, max(near.values(), default=_IN_ANOTHER))
    return [label for label in labels if near[PurePath(label.filename).parent] >= least]


def _nearness(parent: PurePath, truth: Path, folder: Path) -> int:
    """Tell how surely a folder, as a label names it, is a folder of a recording."""
    real = os.path.realpath(folder)
    if os.path.realpath(truth.parent / parent) == real:
        return _IN_FOLDER
    return _MAY_BE_IN_FOLDER if parent.name in ("", PurePath(real).name) else _IN_ANOTHER


def _labels_of(source: Source, labels: list[Label], truth: Path) -> list[Label]:
    """Return the labels that speak of this source, of all the labels in a file."""
    path = plain_path(source.path)
    own = [label for label in labels if PurePath(label.filename).name == path.name]
    if own:
        return _own_labels(own, truth, path.parent)
    names = {label.filename for label in labels}
    if len(names) > 1:
        raise RecordingError(
            f"{truth}: labels {len(names)} recordings, none of them named {path.name}"
        )
    return labels


def _numbered_labels(source: Source, labels: list[Label], truth: Path) -> dict[int, Label]:
    numbered = {
        label.frame: label
        for label in labels
        if label.frame is not None and (not source.frame_count or label.frame < source.frame_count)
    }
    if not numbered:
        raise RecordingError(
            f"{truth}: has no label of the form FILE:FRAME for a frame of {source.path}"
        )
    return numbered


def _picture_labels(
    source: ImageFolderSource, labels: list[Label], truth: Path
) -> dict[int, Label]:
    numbers = {picture.name: index for index, picture in enumerate(source.pictures)}
    named = [label for label in labels if PurePath(label.filename).name in numbers]
    own = _own_labels(named, truth, source.path)
    return {numbers[PurePath(label.filename).name]: label for label in own}


def _entry_labels(source: SequenceFileSource, labels: list[Label]) -> dict[int, Label]:
    numbers = {str(entry): index for index, entry in enumerate(source.entries)}
    named = ((numbers.get(str(label)), label) for label in labels)
    return {number: label for number, label in named if number is not None}
