"""How a file of labels calls the frames of a recording."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.labels.label_match import labels_near, plain_path
from cable_tracker.sequences.labels.sequence_file import Label, SequenceFileSource
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.source_base import Source

FrameName = tuple[str, int | None]
"""File name, relative to the folder of the label file, and number of the frame in it if any."""


class FrameNames(ABC):
    """The names of a recording's frames.

    Parameters
    ----------
    what : str
        A frame of the recording, in words.
    numbers : mapping of str to int
        Numbers of the frames by their names.
    """

    def __init__(self, what: str, numbers: Mapping[str, int] = MappingProxyType({})) -> None:
        self._what = what
        self._numbers = numbers

    @abstractmethod
    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame in a label file that lies in a folder."""

    def frames(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label of a file; None for labels of another recording.

        Raises
        ------
        RecordingError
            The file labels other recordings only.
        """
        found = self._found(labels, file)
        if found and all(frame is None for frame in found):
            raise RecordingError(
                f"{file}: holds labels, but none for {self._what}; name another file with --labels"
            )
        return found

    def _found(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Return the frame of each label of a file, if any."""
        return [self._numbers.get(str(label)) for label in labels]


def names_of(source: Source) -> FrameNames:
    """Return the names of the frames of an open recording."""
    if isinstance(source, ImageFolderSource):
        return PictureNames(source.path, [picture.name for picture in source.pictures])
    if isinstance(source, SequenceFileSource):
        return EntryNames(source.path, source.entries)
    return NumberedNames(source.path)


@lru_cache(maxsize=64)
def _seen_from(folder: Path, path: Path) -> str | None:
    """Return the name of a file as a label file in a folder writes it; None if it is not inside."""
    path, folder = plain_path(path), plain_path(folder)
    inside = path.is_relative_to(folder) and path != folder
    return path.relative_to(folder).as_posix() if inside else None


class NumberedNames(FrameNames):
    """Frames of a bag or a video: ``NAME:FRAME``."""

    def __init__(self, recording: Path) -> None:
        super().__init__(f"a frame of {recording} (FILE:FRAME)")
        self._recording = recording

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`.

        A label file that lies elsewhere names the recording without its folder; its labels can be
        given as truth all the same.
        """
        return _seen_from(folder, self._recording) or plain_path(self._recording).name, frame

    def _found(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        """Count labels of a single file that is gone as of this one, which was then renamed."""
        recording = plain_path(self._recording)
        own = [label for label in labels if Path(label.filename).name == recording.name]
        others = {label.filename for label in labels}
        if len(others) == 1 and not own and not (file.parent / others.pop()).exists():
            own = list(labels)
        near = set(map(id, labels_near(own, file, recording.parent)))
        return [label.frame if id(label) in near else None for label in labels]


class PictureNames(FrameNames):
    """Pictures of a folder, by their file names in the order of the frames."""

    def __init__(self, folder: Path, pictures: Sequence[str]) -> None:
        numbers = {name: number for number, name in enumerate(pictures)}
        super().__init__(f"a picture in {folder}", numbers)
        self._folder = folder
        self._pictures = tuple(pictures)

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        picture = self._pictures[frame]
        elsewhere = f"{plain_path(self._folder).name}/{picture}"
        return _seen_from(folder, self._folder / picture) or elsewhere, None

    def _found(self, labels: Sequence[Label], file: Path) -> list[int | None]:
        own = set(map(id, labels_near(labels, file, self._folder)))
        return [
            self._numbers.get(Path(str(label)).name) if id(label) in own else None
            for label in labels
        ]


class EntryNames(FrameNames):
    """Frames of an image-sequence file, called as they are there.

    Raises
    ------
    RecordingError
        The file lists a frame more than once: its labels could not be told apart.
    """

    def __init__(self, sequence: Path, entries: Sequence[Label]) -> None:
        numbers = {str(entry): number for number, entry in enumerate(entries)}
        if len(numbers) < len(entries):
            (name, count), *_ = Counter(map(str, entries)).most_common(1)
            raise RecordingError(
                f"{sequence}: lists {name} {count} times, and labels go by name; list it once"
            )
        super().__init__(f"a frame that {sequence} lists", numbers)
        self._entries = tuple(entries)

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        entry = self._entries[frame]
        return entry.filename, entry.frame
