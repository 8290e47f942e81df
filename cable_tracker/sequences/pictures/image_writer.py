"""Write frames as pictures, with a sequence file for those that are labelled."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path

from cable_tracker.arrays import Image, eight_bits
from cable_tracker.atomic_output import output_folder
from cable_tracker.sequences.encodings import decode_bgr, decode_grey
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.labels.sequence_file import Label, write_labels
from cable_tracker.sequences.pictures.encoded_pictures import png_bytes
from cable_tracker.sequences.pictures.image_folder import SEQUENCE_NAME

_PICTURE_NAME = re.compile(r"frame_[0-9]{6,}\.png")
_GREY_ENCODINGS = ("mono8", "8UC1", "mono16", "16UC1", "32FC1")


def picture_name(index: int) -> str:
    """Return the file name of a frame."""
    return f"frame_{index:06d}.png"


def pictures_beside(list_name: str) -> Callable[[str], bool]:
    """Return a test of whether a file is a written frame, or the list of what is in the frames."""
    return lambda name: name == list_name or _PICTURE_NAME.fullmatch(name) is not None


def _picture(image: RawImage | CompressedImage) -> Image:
    if isinstance(image, RawImage) and image.encoding in _GREY_ENCODINGS:
        return eight_bits(decode_grey(image))
    return decode_bgr(image)


def write_picture(path: Path, image: RawImage | CompressedImage) -> None:
    """Write one frame as an 8-bit PNG; grey encodings become grey, all others blue-green-red.

    Raises
    ------
    FrameError
        It cannot be decoded or encoded.
    """
    path.write_bytes(png_bytes(_picture(image)))


def _write_all(folder: Path, frames: Iterable[Frame]) -> int:
    labels = []
    count = 0
    for frame in frames:
        name = picture_name(frame.index)
        write_picture(folder / name, frame.image)
        if frame.truth is not None:
            labels.append(Label(name, state=frame.truth))
        count += 1
    write_labels(folder / SEQUENCE_NAME, labels)
    return count


def write_sequence(folder: Path, frames: Iterable[Frame], *, overwrite: bool = False) -> int:
    """Write each frame as an 8-bit PNG, and `sequence.txt` in the format of the thesis.

    All frames are written as pictures. Frames without ground truth do not appear in the sequence
    file, for it has no way to say so. The folder appears when all is written; if anything goes
    wrong, also in the frames, nothing is left.

    Parameters
    ----------
    frames : iterable of Frame
        Grey encodings become grey pictures, all others blue-green-red.
    overwrite : bool
        Replace a sequence that lies there, or an empty folder. Anything else is never replaced, nor
        a sequence beside which the user has put other files.

    Returns
    -------
    int
        Number of pictures.

    Raises
    ------
    OutputError
        The folder exists, or the disk does not let us write.
    FrameError
        A frame cannot be decoded.
    """
    with output_folder(
        folder, SEQUENCE_NAME, overwrite=overwrite, is_own_name=pictures_beside(SEQUENCE_NAME)
    ) as content:
        return _write_all(content, frames)
