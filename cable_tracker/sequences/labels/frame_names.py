"""Names of a recording's frames in label files."""

from __future__ import annotations

import os.path
from abc import ABC, abstractmethod
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache
from pathlib import Path, PurePath

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.labels.sequence_file import FrameName, SequenceFileSource
from cable_tracker.sequences.pictures.image_folder import ImageFolderSource
from cable_tracker.sequences.source_base import Source

_IN_ANOTHER, _MAY_BE_IN_FOLDER, _IN_FOLDER = range(3)
"""How surely a labelled file lies in a folder, see `_nearness`."""


class FrameNames(ABC):
    """The names of a recording's frames.

    Attributes
    ----------
    what : str
        A frame of the recording, in words.
    """

    def __init__(self, what: str) -> None:
        self.what = what

    @abstractmethod
    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame in a label file that lies in a folder."""

    @abstractmethod
    def own_frames(self, labels: Sequence[FrameName], file: Path) -> dict[str, int | None]:
        """Return the frames of those labels of a file that are of this recording, by their names.

        None: the recording holds no such frame.

        Raises
        ------
        RecordingError
            Two labelled files have one name, and nothing tells which of them is meant.
        """

    def lists(self, filename: str) -> bool:
        """Tell whether frames of a file of this name are listed, whichever of them."""
        return False

    def frames(self, labels: Sequence[FrameName], file: Path) -> list[int | None]:
        """Return the frame of each label of a file; None for labels of another recording.

        Raises
        ------
        RecordingError
            The file labels other recordings only, or as `own_frames`.
        """
        own = self.own_frames(labels, file)
        found = [own.get(str(label)) for label in labels]
        if found:
            self.need_any(found, file)
        return found

    def need_any(self, frames: Collection[int | None], file: Path) -> None:
        """Refuse a file of labels of which none has a frame here."""
        if all(frame is None for frame in frames):
            raise RecordingError(
                f"{file}: holds labels, but none for a {self.what}; name another file"
            )


def names_of(source: Source) -> FrameNames:
    """Return the names of the frames of an open recording."""
    if isinstance(source, ImageFolderSource):
        return PictureNames(source.path, [picture.name for picture in source.pictures])
    if isinstance(source, SequenceFileSource):
        return EntryNames(source.path, source.entries)
    return NumberedNames(source.path)


def plain_path(path: Path) -> Path:
    """Return an absolute path without ``..``; links are followed only where there is one.

    A recording that is named ``.`` has its name there.
    """
    absolute = path.absolute()
    return absolute.resolve() if ".." in absolute.parts else absolute


@lru_cache(maxsize=64)
def _relative_name(folder: Path, path: Path) -> str | None:
    """Return the name of a file as a label file in a folder writes it; None if it is not inside."""
    path, folder = plain_path(path), plain_path(folder)
    inside = path.is_relative_to(folder) and path != folder
    return path.relative_to(folder).as_posix() if inside else None


def _files_of(folder: Path, filenames: Iterable[str], file: Path) -> set[str]:
    """Return the file names in a label file that may belong to a folder of pictures.

    A label names its file relative to the folder of the label file, or to another one if either
    has been moved. Those of another folder are left out where others are of this one, and where
    the same name comes in several folders, all but those of the nearest.

    Raises
    ------
    RecordingError
        Two files have one name, and nothing tells which of them is meant.
    """
    files = sorted(set(filenames))
    parents = {PurePath(filename).parent for filename in files}
    near = {parent: _nearness(parent, file, folder) for parent in parents}
    least = min(_MAY_BE_IN_FOLDER, max(near.values(), default=_IN_ANOTHER))
    alike: dict[str, dict[int, list[str]]] = defaultdict(lambda: defaultdict(list))
    for filename in files:
        path = PurePath(filename)
        if near[path.parent] >= least:
            alike[path.name][near[path.parent]].append(filename)
    own: set[str] = set()
    for by_nearness in alike.values():
        nearest = max(by_nearness)
        first, *others = by_nearness[nearest]
        if nearest < _IN_FOLDER and others:
            raise RecordingError(
                f"{file}: labels {first} and {others[0]}, either of which may be that of {folder};"
                " give a file with labels of one folder"
            )
        own |= {first, *others}
    return own


def _nearness(parent: PurePath, file: Path, folder: Path) -> int:
    """Return how surely a folder named in a label is the recording's folder, as a rank."""
    real = os.path.realpath(folder)
    if os.path.realpath(file.parent / parent) == real:
        return _IN_FOLDER
    return _MAY_BE_IN_FOLDER if parent.name in ("", PurePath(real).name) else _IN_ANOTHER


class NumberedNames(FrameNames):
    """Frames of a bag or a video: ``NAME:FRAME``."""

    def __init__(self, recording: Path) -> None:
        super().__init__(f"frame of {recording} (FILE:FRAME)")
        self._recording = recording

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`.

        A label file that lies elsewhere names the recording without its folder; its labels can be
        given as truth all the same.
        """
        seen = _relative_name(folder, self._recording)
        return FrameName(seen or plain_path(self._recording).name, frame)

    def own_frames(self, labels: Sequence[FrameName], file: Path) -> dict[str, int | None]:
        """Count labels of a single file that is gone as of this one, which was then renamed."""
        recording = plain_path(self._recording)
        files = {label.filename for label in labels}
        named = (filename for filename in files if PurePath(filename).name == recording.name)
        own = _files_of(recording.parent, named, file)
        if not own and len(files) == 1 and not any((file.parent / each).exists() for each in files):
            own = files
        return {str(label): label.frame for label in labels if label.filename in own}


class PictureNames(FrameNames):
    """Pictures of a folder, by their file names in the order of the frames."""

    def __init__(self, folder: Path, pictures: Sequence[str]) -> None:
        super().__init__(f"picture in {folder}")
        self._folder = folder
        self._pictures = tuple(pictures)
        self._numbers = {name: number for number, name in enumerate(pictures)}

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        picture = self._pictures[frame]
        elsewhere = f"{plain_path(self._folder).name}/{picture}"
        return FrameName(_relative_name(folder, self._folder / picture) or elsewhere)

    def own_frames(self, labels: Sequence[FrameName], file: Path) -> dict[str, int | None]:
        """Count what stands in a folder with pictures from here; see `FrameNames`."""
        names = {
            label.filename: PurePath(label.filename) for label in labels if label.frame is None
        }
        known = [filename for filename, path in names.items() if path.name in self._numbers]
        own = _files_of(self._folder, known, file)
        folders = {names[filename].parent for filename in own}
        return {
            filename: self._numbers.get(path.name)
            for filename, path in names.items()
            if filename in own or (path.parent in folders and path.name not in self._numbers)
        }


class EntryNames(FrameNames):
    """Frames of an image-sequence file, called as they are there.

    Raises
    ------
    RecordingError
        The file lists a frame more than once: its labels could not be told apart.
    """

    def __init__(self, sequence: Path, entries: Sequence[FrameName]) -> None:
        super().__init__(f"frame that {sequence} lists")
        self._entries = tuple(entries)
        self._numbers = {str(entry): number for number, entry in enumerate(entries)}
        if len(self._numbers) < len(entries):
            (name, count), *_ = Counter(map(str, entries)).most_common(1)
            raise RecordingError(
                f"{sequence}: lists {name} {count} times, and labels go by name; list it once"
            )

    def name(self, frame: int, folder: Path) -> FrameName:
        """Return the name of a frame; see `FrameNames`."""
        entry = self._entries[frame]
        return FrameName(entry.filename, entry.frame)

    def own_frames(self, labels: Sequence[FrameName], file: Path) -> dict[str, int | None]:
        """Pass over names that are not listed; see `FrameNames`."""
        names = map(str, labels)
        return {name: self._numbers[name] for name in names if name in self._numbers}

    def lists(self, filename: str) -> bool:
        """Tell whether it lists frames of a file; see `FrameNames`."""
        return any(entry.filename == filename for entry in self._entries)
