"""How a file of labels calls the frames of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.image_folder import ImageFolderSource
from cable_tracker.sequences.sequence_file import Label, SequenceFileSource
from cable_tracker.sequences.source import Source

FrameName = tuple[str, int | None]
"""File name, relative to the folder of the label file, and number of the frame in it if any."""


class FrameNames(Protocol):
    """The names of a recording's frames."""

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame in a label file that lies in a folder."""
        ...

    def frames(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label of a file; None for labels of another recording.

        Raises
        ------
        RecordingError
            The file labels other recordings only.
        """
        ...


def names_of(source: Source) -> FrameNames:
    """Return the names of the frames of an open recording."""
    if isinstance(source, ImageFolderSource):
        return PictureNames(source.path, [picture.name for picture in source.pictures])
    if isinstance(source, SequenceFileSource):
        return EntryNames(source.path, source.entries)
    return NumberedNames(source.path)


def _plain(path: Path) -> Path:
    """Return an absolute path without ``..``; links are followed only where there is one."""
    absolute = path.absolute()
    return absolute.resolve() if ".." in absolute.parts else absolute


def _seen_from(folder: Path, path: Path) -> str | None:
    """Return the name of a file as a label file in a folder writes it; None if it is not inside."""
    path, folder = _plain(path), _plain(folder)
    inside = path.is_relative_to(folder) and path != folder
    return path.relative_to(folder).as_posix() if inside else None


class NumberedNames:
    """Frames of a bag or a video: ``NAME:FRAME``.

    Parameters
    ----------
    recording : Path
        The bag or video.
    """

    def __init__(self, recording: Path) -> None:
        self._recording = recording

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`.

        A label file that lies elsewhere names the recording without its folder; its labels can be
        given as truth all the same.
        """
        return _seen_from(folder, self._recording) or _plain(self._recording).name, frame

    def frames(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label; see `FrameNames`.

        Labels of a single file of another name count as labels of this one, which may have been
        renamed.
        """
        own = _plain(self._recording).name
        names = {Path(label.filename).name for label in labels}
        if labels and own not in names and len({label.filename for label in labels}) == 1:
            own = next(iter(names))
        found = [label.frame if Path(label.filename).name == own else None for label in labels]
        _need_any(found, file, f"a frame of {self._recording} (FILE:FRAME)")
        return found


class PictureNames:
    """Pictures of a folder, by their file names.

    Parameters
    ----------
    pictures : sequence of str
        Their names, in the order of the frames.
    """

    def __init__(self, folder: Path, pictures: Sequence[str]) -> None:
        self._folder = folder
        self._pictures = tuple(pictures)
        self._numbers = {name: number for number, name in enumerate(pictures)}

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        picture = self._pictures[frame]
        elsewhere = f"{_plain(self._folder).name}/{picture}"
        return _seen_from(folder, self._folder / picture) or elsewhere, None

    def frames(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label; see `FrameNames`."""
        found = [self._numbers.get(Path(str(label)).name) for label in labels]
        _need_any(found, file, f"a picture in {self._folder}")
        return found


class EntryNames:
    """Frames of an image-sequence file, called as they are there."""

    def __init__(self, sequence: Path, entries: Sequence[Label]) -> None:
        self._sequence = sequence
        self._entries = tuple(entries)
        self._numbers = {str(entry): number for number, entry in enumerate(entries)}

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        entry = self._entries[frame]
        return entry.filename, entry.frame

    def frames(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label; see `FrameNames`."""
        found = [self._numbers.get(str(label)) for label in labels]
        _need_any(found, file, f"a frame that {self._sequence} lists")
        return found


def _need_any(found: Sequence[int | None], file: Path, what: str) -> None:
    if found and all(frame is None for frame in found):
        raise RecordingError(
            f"{file}: holds labels, but none for {what}; name another file with --labels"
        )
