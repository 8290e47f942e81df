"""Frames out of a folder of pictures."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from pathlib import Path

import cv2

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError, RecordingError, read_failure
from cable_tracker.sequences.encodings import decode_picture_file, raw_from_array
from cable_tracker.sequences.frame import Frame, RawImage, missing_image
from cable_tracker.sequences.natural_order import gap_note, naturally_sorted, positions_by_number
from cable_tracker.sequences.source_base import ChosenRecording, Source
from cable_tracker.stamps import USUAL_RATE, stamp_of_frame

SEQUENCE_NAME = "sequence.txt"
"""Name of the sequence file with labels of a folder's pictures."""

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm")

_ENCODINGS = {
    ("uint8", 1): "mono8",
    ("uint8", 3): "bgr8",
    ("uint8", 4): "bgra8",
    ("uint16", 1): "mono16",
    ("uint16", 3): "bgr16",
    ("float32", 1): "32FC1",
}


def load_picture(path: Path) -> RawImage:
    """Read a picture file as it was stored: its depth, its channels, not turned by EXIF.

    Raises
    ------
    FrameError
        It cannot be read or decoded; the message is the reason alone, without the path.
    """
    try:
        data = memoryview(path.read_bytes())
    except OSError as error:
        raise FrameError(f"cannot be read: {error.strerror}") from error
    picture = decode_picture_file(data, cv2.IMREAD_UNCHANGED)
    channels = picture.shape[2] if picture.ndim == 3 else 1
    encoding = _ENCODINGS.get((picture.dtype.name, channels))
    if encoding is None:
        raise FrameError(f"pictures of {channels} channels of {picture.dtype} are not supported")
    return raw_from_array(picture, encoding)


def find_pictures(folder: Path) -> list[Path]:
    """Return the pictures of a folder in natural order; hidden files are left out."""
    return naturally_sorted(
        file
        for file in folder.iterdir()
        if file.suffix.lower() in PICTURE_SUFFIXES and not file.name.startswith(".")
    )


class ImageFolderSource(Source):
    """The pictures of a folder, in natural order of their names.

    Where numbers are missing between the names, the pictures keep the time that their numbers say.

    Attributes
    ----------
    pictures : list of Path
        The pictures.

    Raises
    ------
    RecordingError
        The folder is missing or holds no pictures.
    """

    def __init__(self, chosen: ChosenRecording) -> None:
        super().__init__(chosen)
        path = chosen.path
        try:
            self.pictures = find_pictures(path)
        except OSError as error:
            raise read_failure(path, error) from error
        if not self.pictures:
            raise RecordingError(
                f"{path}: holds no pictures ({', '.join(PICTURE_SUFFIXES)}) and no bag"
            )
        self._rate = self.taken_rate = chosen.rate or USUAL_RATE
        names = [picture.name for picture in self.pictures]
        self._positions = positions_by_number(names)
        self._gap_note = gap_note(names, self._positions)
        self.note = self._gap_note
        if (path / SEQUENCE_NAME).is_file():
            unused = f"its labels in {SEQUENCE_NAME} are not used; name that file instead"
            self.note = "; ".join(note for note in (self._gap_note, unused) if note)
        self.frame_count = len(self.pictures)

    def label(self, labels: Mapping[int, CableState]) -> None:
        """Attach ground truth; then nothing need be said of labels that are not used."""
        super().label(labels)
        self.note = self._gap_note

    def frame_name(self, index: int) -> str:
        """Return the name of a frame for messages to the user."""
        return f"frame {index} ({self.pictures[index].name})"

    def _read(self, start: int) -> Generator[Frame]:
        for index, path in enumerate(self.pictures[start:], start):
            stamp = stamp_of_frame(self._positions[index], self._rate)
            try:
                yield Frame(index, stamp, load_picture(path))
            except FrameError as error:
                yield Frame(index, stamp, missing_image(str(error)))
