"""Files of labels: in the format of the thesis, the flags beside, and labels not saved yet.

The last are kept beside the label file, in case that the process dies.
"""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from cable_tracker.atomic_output import write_text
from cable_tracker.cable.model.state import POSE_SYMBOLS, CableState
from cable_tracker.errors import OutputError, RecordingError, one_line, read_failure, write_failure
from cable_tracker.gui.labelling.labels import (
    NO_CABLE,
    FrameLabel,
    Labels,
    Origin,
    flagged_label,
)
from cable_tracker.sequences.labels.frame_names import FrameNames
from cable_tracker.sequences.labels.sequence_file import (
    FrameName,
    Label,
    format_labels,
    parse_name,
    read_any_labels,
)
from cable_tracker.sequences.tables.csv_tables import csv_text

T = TypeVar("T")

FLAGS_HEADER = ("frame", "stamp", "flag", "file")
FLAGS_SUFFIX = ".flags.csv"

AUTOSAVE_HEADER = ("frame", "stamp", "flag", *POSE_SYMBOLS, "file")
AUTOSAVE_SUFFIX = ".autosave"


def read_rows(path: Path, header: Sequence[str], parse: Callable[[list[str]], T]) -> list[T]:
    """Return the parsed rows below the header of a CSV file; empty if there is no file.

    Parameters
    ----------
    header : sequence of str
        Names of the columns, which the first line must be.
    parse : callable
        Turns the fields of a row into its meaning; raises ValueError if they have none.

    Raises
    ------
    RecordingError
        The file cannot be read, or a line is malformed; the message names it.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(
            f"{path}: cannot be read ({one_line(error)}); check or remove the file"
        ) from error
    wanted = ",".join(header)
    if not rows or rows[0] != list(header):
        raise RecordingError(
            f"{path}: line 1 is not the header {wanted}; correct or remove the file"
        )
    parsed = []
    for number, fields in enumerate(rows[1:], start=2):
        try:
            parsed.append(_parsed(fields, len(header), parse))
        except ValueError as error:
            raise RecordingError(
                f"{path}: line {number} is malformed ({one_line(error)}); expected: {wanted};"
                " correct it, or remove the file"
            ) from error
    return parsed


def _parsed(fields: list[str], count: int, parse: Callable[[list[str]], T]) -> T:
    if len(fields) != count:
        raise ValueError(f"{len(fields)} fields instead of {count}")
    return parse(fields)


class OverwriteError(OutputError):
    """Saving would destroy labels that were not shown here; the user must say so."""


@dataclass(frozen=True, slots=True)
class Flag:
    """A line of the file of flags.

    Attributes
    ----------
    frame : int
        Number of the frame.
    stamp : int or None
        Its time [ns]; None if it was not known.
    word : str
        ``hand``, ``proposed``, ``interpolated`` or ``no_cable``.
    name : FrameName
        The frame as the label file calls it.
    """

    frame: int
    stamp: int | None
    word: str
    name: FrameName


@dataclass(frozen=True, slots=True)
class FileContent:
    """Content of a file of labels and its flags.

    Attributes
    ----------
    labels : Labels
        Labels of this recording.
    others : tuple of Label
        Labels of other recordings, which are kept as they are.
    other_flags : tuple of Flag
        Flags of other recordings.
    """

    labels: Labels = field(default_factory=dict)
    others: tuple[Label, ...] = ()
    other_flags: tuple[Flag, ...] = ()


def flags_path(path: Path) -> Path:
    """Return where the flags of a label file lie: ``NAME.flags.csv``."""
    return path.with_name(path.name + FLAGS_SUFFIX)


def read_label_file(path: Path, names: FrameNames, *, allow_outside: bool = False) -> FileContent:
    """Read a label file, with its flags if it has any.

    Labels without a flag count as drawn by hand.

    Parameters
    ----------
    path : Path
        The label file; the flags lie beside it.
    names : FrameNames
        File name and number of each frame of the recording.
    allow_outside : bool
        Whether it may name files outside its folder.

    Raises
    ------
    RecordingError
        A file cannot be read, a line is malformed, or it labels other recordings only; the message
        names the line.
    """
    read = read_any_labels(path, allow_outside=allow_outside)
    flags = read_rows(flags_path(path), FLAGS_HEADER, _parse_flag)
    # Names of both files are looked at together: a recording that was renamed is in both.
    frames = names.frames([*read, *(flag.name for flag in flags)], path)
    states, others = {}, []
    for label, frame in zip(read, frames[: len(read)], strict=True):
        if frame is None:
            others.append(label)
        else:
            states[frame] = label.state
    labels = {frame: FrameLabel(state) for frame, state in states.items()}
    other_flags = []
    for flag, frame in zip(flags, frames[len(read) :], strict=True):
        if frame is None:
            other_flags.append(flag)
            continue
        # Where the two disagree, as after a label file was edited elsewhere, the label counts.
        if (frame in states) == (flag.word != NO_CABLE):
            labels[frame] = flagged_label(states.get(frame), flag.word, flag.stamp)
    return FileContent(labels, tuple(others), tuple(other_flags))


def _parse_flag(fields: list[str]) -> Flag:
    frame, stamp, word, name = fields
    if word != NO_CABLE:
        Origin(word)
    return Flag(int(frame), int(stamp) if stamp else None, word, parse_name(name))


def format_label_file(
    content: FileContent, names: FrameNames, folder: Path, *, allow_outside: bool = False
) -> tuple[str, str]:
    """Return the texts of a label file in a folder and of its flags.

    Raises
    ------
    ValueError
        A name would not be read back as it is.
    """
    labels = [*content.others]
    rows = [(flag.frame, flag.stamp, flag.word, flag.name) for flag in content.other_flags]
    for frame, label in sorted(content.labels.items()):
        name = names.name(frame, folder)
        if label.state is not None:
            labels.append(Label(name.filename, name.frame, state=label.state))
        rows.append((frame, label.stamp, label.flag, name))
    flags = csv_text(FLAGS_HEADER, rows)
    return format_labels(labels, allow_outside=allow_outside), flags


def digest(path: Path) -> str | None:
    """Return a digest of a label file and its flags; None if there are none.

    Raises
    ------
    RecordingError
        A file cannot be read.
    """
    hasher = hashlib.sha256()
    found = False
    for part in (path, flags_path(path)):
        try:
            with part.open("rb") as file:
                content = hashlib.file_digest(file, "sha256").digest()
        except FileNotFoundError:
            hasher.update(b"-")
            continue
        except OSError as error:
            raise read_failure(part, error) from error
        found = True
        hasher.update(b"+" + content)
    return hasher.hexdigest() if found else None


class LabelFile:
    """A label file that is open, and how it was when it was last read or written here.

    Parameters
    ----------
    path : Path
        Path of the label file, which may not exist yet.
    names : FrameNames
        File name and number of each frame of the recording.
    allow_outside : bool
        Whether it may name files outside its folder.
    """

    def __init__(self, path: Path, names: FrameNames, *, allow_outside: bool = False) -> None:
        self.path = path
        self._names = names
        self._allow_outside = allow_outside
        self._digest: str | None = None

    def read(self) -> FileContent:
        """Read it; empty if there is none. See `read_label_file`."""
        try:
            is_there = self.path.exists()
        except OSError as error:
            raise read_failure(self.path, error) from error
        if not is_there:
            self._digest = None
            return FileContent()
        # A recording, which may be huge, is refused at its first line, before all of it is read.
        read_any_labels(self.path, allow_outside=self._allow_outside)
        self._digest = digest(self.path)
        return read_label_file(self.path, self._names, allow_outside=self._allow_outside)

    def write(self, content: FileContent, *, overwrite: bool = False) -> None:
        """Write it, and its flags.

        Parameters
        ----------
        overwrite : bool
            Whether labels of another program or user may be lost.

        Raises
        ------
        OverwriteError
            Another file lies there, or it has changed since it was read or written here.
        OutputError
            It cannot be written, or a file of another kind lies there; that is as it was.
        """
        if self._digest is None:
            self._need_label_file()
        present = digest(self.path)
        if not overwrite and present is not None and present != self._digest:
            raise OverwriteError(
                f"{self.path} exists already; its labels would be lost"
                if self._digest is None
                else f"{self.path} has changed on the disk since it was opened here; the changes"
                " would be lost"
            )
        try:
            texts = format_label_file(
                content,
                self._names,
                self.path.absolute().parent,
                allow_outside=self._allow_outside,
            )
            # Labels first: a label without its flag is still a label.
            write_text(self.path, texts[0])
            try:
                write_text(flags_path(self.path), texts[1])
            finally:
                self._digest = digest(self.path)
        except (OSError, ValueError) as error:
            raise write_failure(self.path, error) from error

    def _need_label_file(self) -> None:
        """Refuse to replace a file that is no label file, such as a recording or a program."""
        refusal = f"{self.path}: is no label file and is not replaced; choose another name"
        try:
            if not self.path.exists():
                return
            if not self.path.is_file():
                raise OutputError(refusal)
        except OSError as error:
            raise write_failure(self.path, error) from error
        try:
            read_any_labels(self.path, allow_outside=True)
        except RecordingError as error:
            raise OutputError(refusal) from error


def autosave_path(path: Path) -> Path:
    """Return where the unsaved labels of a label file lie: ``NAME.autosave``."""
    return path.with_name(path.name + AUTOSAVE_SUFFIX)


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
    write_text(path, csv_text(AUTOSAVE_HEADER, rows), waits=False)


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
    rows = read_rows(path, AUTOSAVE_HEADER, _parse_autosaved)
    try:
        frames = names.frames([name for _, name in rows], path)
    except RecordingError as error:
        raise RecordingError(
            f"{path}: holds unsaved labels, but not of this recording; move it away, or remove it"
        ) from error
    return {
        frame: label for frame, (label, _) in zip(frames, rows, strict=True) if frame is not None
    }


def _parse_autosaved(fields: list[str]) -> tuple[FrameLabel, FrameName]:
    _, stamp, flag, *places, name = fields
    state = None if flag == NO_CABLE else _finite_state(places)
    return flagged_label(state, flag, int(stamp) if stamp else None), parse_name(name)


def _finite_state(places: list[str]) -> CableState:
    distance, angle, width, skew = map(float, places)
    state = CableState(distance, angle, width, skew)
    if not state.is_finite():
        raise ValueError("a number is not finite")
    return state
