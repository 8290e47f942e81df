"""The file of labels in the format of the thesis, and the file of flags beside it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

from cable_tracker.atomic_output import write_text
from cable_tracker.errors import OutputError, RecordingError, read_failure, write_failure
from cable_tracker.gui.labelling.csv_rows import read_rows
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

FLAGS_HEADER = ("frame", "stamp", "flag", "file")
FLAGS_SUFFIX = ".flags.csv"


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
