"""One recording that is being labelled: its frames, its labels and their files.

All browsers share it. Its methods belong to the thread of the server, but for `picture` and
`propose`, which take a while and may be called from any thread.
"""

from __future__ import annotations

import os
import threading
import time
from collections import ChainMap
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import OutputError, ParameterError, RecordingError, one_line
from cable_tracker.gui.labelling.document import Changes, Gap, LabelDocument
from cable_tracker.gui.labelling.label_file import (
    FileContent,
    LabelFile,
    OverwriteError,
    autosave_path,
    read_autosave,
    write_autosave,
)
from cable_tracker.gui.labelling.labels import FrameLabel, Labels, stamps_of
from cable_tracker.gui.labelling.pictures import Picture, Pictures
from cable_tracker.gui.labelling.proposals import LabelProposal, Proposer
from cable_tracker.printable import printable
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.labels.frame_names import FrameNames, names_of
from cable_tracker.sequences.labels.sequence_file import (
    SEQUENCE_SUFFIXES,
    FrameName,
    SequenceFileSource,
    is_usable,
)
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.source_base import Source

Listener: TypeAlias = Callable[[Changes | None], None]
"""Told of changed labels; None: all of them, or their files, may have changed."""


def default_label_file(source: Path) -> Path:
    """Return where the labels of a recording go: ``SOURCE.txt``, here if not beside it.

    The labels of a sequence file go into a file of their own: saving must not change what the
    recording is made of.
    """
    resolved = source.resolve()
    ending = ".labels.txt" if resolved.suffix.lower() in SEQUENCE_SUFFIXES else ".txt"
    name = resolved.name + ending
    beside = resolved.with_name(name)
    return beside if beside.exists() or os.access(resolved.parent, os.W_OK) else Path(name)


def _need_usable_names(source: Source, names: FrameNames, folder: Path) -> None:
    """Refuse a recording whose frames a label file cannot name: its labels could not be saved.

    Raises
    ------
    RecordingError
        A picture or the recording must be renamed first.
    """
    pictures = source.pictures if isinstance(source, ImageFolderSource) else ()
    odd = (
        number for number, picture in enumerate(pictures) if not is_usable(FrameName(picture.name))
    )
    # The first one stands for the folder of all; names of thousands take seconds.
    for frame in (0, *odd):
        frame_name = names.name(frame, folder)
        if is_usable(frame_name):
            continue
        name = frame_name.filename
        if name != printable(name):
            raise RecordingError(
                f"{printable(name)}: labels cannot name it, for its name is not UTF-8; rename it,"
                " for example with convmv"
            )
        raise RecordingError(
            f"{name!r}: labels cannot name it, for its name begins with a blank or holds a control"
            " character; rename it"
        )


class Workspace:
    """Recording and labels that the window works on.

    Parameters
    ----------
    path : Path
        Label file, which may not exist yet.
    allow_outside : bool
        Whether label files may name files outside their folder.

    Attributes
    ----------
    autosaved : Labels or None
        Unsaved labels of an earlier run, until the user has said what is to become of them.
    trouble : str
        Reason why labels cannot be saved at the moment; empty if they can.

    Raises
    ------
    RecordingError
        The label file or the unsaved labels cannot be read.
    """

    def __init__(self, source: Source, path: Path, *, allow_outside: bool = False) -> None:
        self.source = source
        self.access = FrameAccess(source)
        self._names = names_of(source)
        self._allow_outside = allow_outside
        self._pictures = Pictures(self.access)
        self._proposer = Proposer(self.access.frame, preset("default"))
        # Times of frames as they were read here.
        self._times: dict[int, int] = {}
        self._listeners: set[Listener] = set()
        self.stopped = threading.Event()
        self.trouble = ""
        _need_usable_names(source, self._names, path.absolute().parent)
        self._open(path)

    def _open(self, path: Path) -> None:
        file = LabelFile(path, self._names, allow_outside=self._allow_outside)
        content = file.read()
        if not path.exists() and isinstance(self.source, SequenceFileSource):
            content = FileContent(
                {
                    number: FrameLabel(entry.state)
                    for number, entry in enumerate(self.source.entries)
                }
            )
        self.autosaved = self._unsaved(path, content)
        self._owns_autosave = False
        self._file, self._content = file, content
        # Times of frames as they stand in files.
        self._known = stamps_of(content.labels)
        self.document = LabelDocument(content.labels, ChainMap(self._times, self._known))

    def _unsaved(self, path: Path, content: FileContent) -> Labels | None:
        """Return the autosaved labels, if they differ from those of the file."""
        kept = autosave_path(path)
        if not kept.exists():
            return None
        labels = read_autosave(kept, self._names)
        return labels if labels != content.labels else None

    def describe_autosaved(self) -> str:
        """Describe the unsaved labels of an earlier run to the user."""
        kept = autosave_path(self.path)
        count = len(self.autosaved or {})
        try:
            written = kept.stat().st_mtime
            is_older = self.path.exists() and written < self.path.stat().st_mtime
        except OSError:
            return f"There are {count} labelled frames of an earlier run."
        when = time.strftime("%Y-%m-%d %H:%M", time.localtime(written))
        message = f"{count} labelled frames of {when} were found in {kept.name}."
        return f"{message} They are older than {self.path.name}." if is_older else message

    @property
    def path(self) -> Path:
        """The label file."""
        return self._file.path

    @property
    def count(self) -> int | None:
        """Number of frames; None while it is unknown."""
        return self.access.count

    @property
    def is_changed(self) -> bool:
        """Whether there are labels that are not saved."""
        return self.document.labels != self._content.labels

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call a listener with every change; returns the function that ends it."""
        self._listeners.add(listener)
        return lambda: self._listeners.discard(listener)

    def notify(self, changes: Changes | None) -> None:
        """Call all listeners with what has changed."""
        for listener in tuple(self._listeners):
            listener(changes)

    def picture(self, frame: int) -> Picture:
        """Return the picture of a frame; see `Pictures.picture`."""
        made = self._pictures.picture(frame)
        self._times[frame] = made.stamp
        return made

    def stamp(self, frame: int) -> int | None:
        """Return the time of a frame [ns]: that at which its label was drawn, or that of now.

        A label that is as it was saved may be of another picture, whatever was drawn meanwhile.
        """
        label = self.document.labels.get(frame)
        if label is not None and label.stamp is not None:
            return label.stamp
        return self.document.times.get(frame)

    def is_displaced(self, picture: Picture) -> bool:
        """Tell whether the frame of a picture was labelled when its number had another time.

        Labels then belong to other frames: the recording was cut, or it is another one. Pictures
        have no times of their own.
        """
        has_times = not isinstance(self.source, (ImageFolderSource, SequenceFileSource))
        return has_times and self.stamp(picture.frame) != picture.stamp

    def propose(
        self, frame: int, labels: Labels, is_awaited: Callable[[], bool] = lambda: True
    ) -> LabelProposal:
        """Propose a label, given copied labels; see `Proposer.propose`."""
        return self._proposer.propose(
            frame, labels, lambda: self.stopped.is_set() or not is_awaited()
        )

    def read_stamps(self, frames: Iterable[int]) -> RecordingError | None:
        """Read the times of frames, as far as they can be read; from any thread.

        The first damage that was met is returned.
        """
        damage = None
        for frame in sorted(frames):
            if self.stopped.is_set():
                break
            try:
                self._times[frame] = self.access.frame(frame).stamp
            except IndexError:
                break
            except RecordingError as error:
                damage = damage or error
        return damage

    def missing_stamps(self, frames: Iterable[int]) -> list[int]:
        """Return the frames whose times must be read.

        Those that stand in a file serve for new labels, too, if no frame read here has another one.
        """
        times_here = dict(self._times)
        is_another = any(self._known.get(frame, now) != now for frame, now in times_here.items())
        known = times_here if is_another else self.document.times
        stamped, count = stamps_of(self.document.labels), self.count
        return [
            frame
            for frame in frames
            if frame not in stamped and frame not in known and (count is None or frame < count)
        ]

    def need_frame(self, frame: int) -> None:
        """Refuse to label what is no frame.

        Raises
        ------
        ParameterError
            There is no such frame.
        """
        if frame < 0 or (self.count is not None and frame >= self.count):
            raise ParameterError(f"there is no frame {frame}; choose one of the recording")

    def change(self, frame: int, label: FrameLabel | None, *, merges: bool = False) -> None:
        """Label a frame; see `LabelDocument.change`. The label is of the time that it has now."""
        changes = self.document.change(frame, {frame: label}, merges=merges)
        self.notify({frame: label, **changes})

    def undo(self) -> tuple[int, Changes] | None:
        """Take the last step back; see `LabelDocument.undo`."""
        return self._notify_step(self.document.undo())

    def redo(self) -> tuple[int, Changes] | None:
        """Do again what was taken back; see `LabelDocument.redo`."""
        return self._notify_step(self.document.redo())

    def _notify_step(self, step: tuple[int, Changes] | None) -> tuple[int, Changes] | None:
        if step is not None:
            self.notify(step[1])
        return step

    def interpolate(self, frame: int, wanted: list[Gap]) -> None:
        """Fill gaps between key frames."""
        self.notify(self.document.interpolate(frame, wanted))

    def save(self, *, overwrite: bool = False) -> None:
        """Write the labels into their file, and forget the autosaved ones.

        Raises
        ------
        OverwriteError
            Labels of another program or user would be lost.
        OutputError
            The file cannot be written.
        """
        self._write_to(self._file, overwrite)

    def save_as(self, path: Path, *, overwrite: bool = False) -> None:
        """Write the labels into another file, which is the label file from now on; see `save`."""
        old, owned = autosave_path(self.path), self._owns_autosave
        if path.resolve() == self.path.resolve():
            self._write_to(self._file, overwrite)
            return
        if not overwrite and autosave_path(path).exists():
            raise OverwriteError(
                f"there are unsaved labels of {path.name} from before; they would be lost"
            )
        file = LabelFile(path, self._names, allow_outside=self._allow_outside)
        self._write_to(file, overwrite)
        if owned:
            old.unlink(missing_ok=True)

    def _write_to(self, file: LabelFile, overwrite: bool) -> None:
        content = replace(self._content, labels=self._stamped_labels())
        file.write(content, overwrite=overwrite)
        self._file, self._content = file, content
        autosave_path(file.path).unlink(missing_ok=True)
        self._owns_autosave = False
        self.trouble = ""
        self.notify({})

    def _stamped_labels(self) -> dict[int, FrameLabel]:
        """Return the labels with their times, as far as they are known."""
        labels = self.document.labels
        return {frame: replace(label, stamp=self.stamp(frame)) for frame, label in labels.items()}

    def open(self, path: Path) -> None:
        """Work on another label file.

        Raises
        ------
        RecordingError
            It is missing or cannot be read. Nothing has changed.
        OutputError
            What was not saved cannot be kept; it is still being worked on.
        """
        if not path.is_file():
            raise RecordingError(f"{path}: there is no such file; check the path")
        # What was not saved stays beside its own file, and is offered when that is opened again.
        self.autosave()
        if self.trouble:
            raise OutputError(f"{self.trouble}; save the labels elsewhere before you open others")
        self._open(path)
        self.notify(None)

    def resume(self) -> None:
        """Take up the unsaved labels of an earlier run."""
        if self.autosaved is not None:
            self.document.replace(self.autosaved)
            self._known |= stamps_of(self.autosaved)
            self.autosaved = None
            self._owns_autosave = True
            self.notify(None)

    def discard(self) -> None:
        """Forget the unsaved labels of an earlier run."""
        if self.autosaved is not None:
            self.autosaved = None
            autosave_path(self.path).unlink(missing_ok=True)
            self.notify(None)

    def autosave(self) -> None:
        """Save changed labels beside the label file; without changes, remove what was saved so.

        What another window on the same file has saved stays.
        """
        if self.autosaved is not None:
            return
        path = autosave_path(self.path)
        try:
            if self.is_changed:
                write_autosave(path, self._stamped_labels(), self._names)
                self._owns_autosave = True
            elif self._owns_autosave:
                path.unlink(missing_ok=True)
            trouble = ""
        except (OSError, ValueError) as error:
            trouble = f"unsaved labels cannot be kept in {path} ({one_line(error)})"
        if trouble != self.trouble:
            self.trouble = trouble
            self.notify({})
