"""The image-sequence file of the thesis: pictures by name, each with the true cable.

One line per frame, ``d alpha w beta # filename`` (pixels and radians), where the file name is
relative to the folder of the text file. ``video.mp4:12`` means frame 12, from 0, of a video. Lines
that begin with ``#`` are comments.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path, PurePosixPath

from cable_tracker.cable.model.geometry import wrapped_cable
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import (
    FrameError,
    OutputError,
    RecordingError,
    one_line,
    read_failure,
    write_failure,
)
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame, missing_image
from cable_tracker.sequences.natural_order import gap_note, positions_by_number
from cable_tracker.sequences.pictures.image_folder import PICTURE_SUFFIXES, load_picture
from cable_tracker.sequences.source_base import ChosenRecording, Source, damage
from cable_tracker.sequences.videos.video import TIMES_NOTE, VIDEO_SUFFIXES
from cable_tracker.sequences.videos.video_frames import (
    VideoFrames,
    opened_video,
    times_run_backwards,
)
from cable_tracker.stamps import NANOSECONDS, USUAL_RATE, stamp_of_frame

SEQUENCE_SUFFIXES = (".txt", ".seq")
APART = 100_000 * NANOSECONDS
"""Time between the beginnings of two recordings of one list [ns]: longer than a dive."""
_HEADER = "# CableDistance CableAngle CableWidth CableSkew # Filename\n"
_LONGEST_LINE = 10_000
_LARGEST_ANGLE = math.tau
"""Largest alpha that is read [rad]: one that is counted from 0 on, or once round, is no larger."""
_LARGEST_SKEW = math.pi / 2
"""Largest beta [rad]: borders that stand across the centreline."""


@dataclass(frozen=True, slots=True)
class FrameName:
    """How a sequence file calls a frame.

    Attributes
    ----------
    filename : str
        The picture or video, relative to the folder of the sequence file.
    frame : int or None
        Frame number in a video, from 0; None for a picture.
    """

    filename: str
    frame: int | None = None

    def __str__(self) -> str:
        return self.filename if self.frame is None else f"{self.filename}:{self.frame}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Label(FrameName):
    """The true cable in a frame that is named.

    Attributes
    ----------
    state : CableState
        d, alpha, w, beta [px, rad]; the rates are zero.
    line : int
        Number of its line in the sequence file that it was read from, from 1; else 0.
    """

    state: CableState
    line: int = field(default=0, compare=False)


def parse_name(text: str) -> FrameName:
    """Return the name of a picture, or of a video with the frame's number."""
    filename, colon, number = text.rpartition(":")
    if colon and filename and number.isascii() and number.isdecimal():
        return FrameName(filename, int(number))
    return FrameName(text)


def _check_name(name: str, allow_outside: bool = False) -> None:
    path = PurePosixPath(name)
    outside = path.is_absolute() or ".." in path.parts
    if (outside and not allow_outside) or "\0" in name:
        # The name last: a long message is cut off at its end.
        raise ValueError(
            "it names a file outside its folder, which one that you trust may do with"
            f" --allow-outside (node: allow_outside): {name!r}"
        )


def _check_video(named: FrameName) -> None:
    """See that a video is named with the number of a frame, and with nothing else behind a colon.

    Raises
    ------
    ValueError
        It is not.
    """
    if named.frame is not None:
        return
    filename = named.filename
    name, colon, rest = filename.rpartition(":")
    is_picture = PurePosixPath(rest).suffix.lower() in PICTURE_SUFFIXES
    if colon and name.lower().endswith(VIDEO_SUFFIXES) and not is_picture:
        raise ValueError(f"{rest!r} is no number of a frame of {name}")
    if filename.lower().endswith(VIDEO_SUFFIXES):
        raise ValueError(f"{filename} is a video; name the frame: FILE:FRAME")


def _check_angles(angle: float, skew: float) -> None:
    """See that alpha and beta can be radians; in degrees they would be wrapped to other cables.

    Raises
    ------
    ValueError
        One of them cannot.
    """
    for name, value, limit in (("alpha", angle, _LARGEST_ANGLE), ("beta", skew, _LARGEST_SKEW)):
        if abs(value) > limit:
            raise ValueError(f"{name} is {value:g}; alpha and beta are in radians, not degrees")


def _parse_line(text: str, line: int, allow_outside: bool) -> Label:
    numbers, hash_sign, name = text.partition("#")
    name = name.strip()
    values = [float(word) for word in numbers.split()]
    if len(values) != 4:
        raise ValueError(f"{len(values)} numbers instead of d alpha w beta")
    if not hash_sign or not name:
        raise ValueError("the file name after # is missing")
    if not all(math.isfinite(value) for value in values):
        raise ValueError("a number is not finite")
    _check_angles(values[1], values[3])
    if values[2] <= 0.0:
        raise ValueError(f"w is {values[2]:g} px; leave out frames without a cable")
    named = parse_name(name)
    _check_name(named.filename, allow_outside)
    _check_video(named)
    state = wrapped_cable(CableState(*values))
    return Label(named.filename, named.frame, state=state, line=line)


def _read_lines(path: Path) -> Iterator[str]:
    try:
        with path.open(encoding="utf-8-sig") as file:
            while line := file.readline(_LONGEST_LINE):
                yield line
    except UnicodeDecodeError as error:
        raise RecordingError(
            f"{path}: is no text; expected lines of the form: d alpha w beta # filename"
        ) from error
    except OSError as error:
        raise read_failure(path, error) from error


def read_labels(path: Path, *, allow_outside: bool = False) -> list[Label]:
    """Read a sequence file.

    Angles outside (-pi/2, pi/2] are wrapped, which turns the signs of d and beta. An alpha beyond
    2 pi and a beta beyond pi/2 are malformed, for they are in degrees; so are widths that are not
    above 0.

    Parameters
    ----------
    allow_outside : bool
        Whether it may name files outside its folder.

    Raises
    ------
    RecordingError
        The file is missing or no text, holds no label, or a line is malformed or names a file
        outside its folder; the message names the line.
    """
    labels = read_any_labels(path, allow_outside=allow_outside)
    if not labels:
        raise RecordingError(f"{path}: holds no labels; expected: d alpha w beta # filename")
    return labels


def read_any_labels(path: Path, *, allow_outside: bool = False) -> list[Label]:
    """Read a sequence file that may hold no label at all; otherwise as `read_labels`."""
    labels = []
    for number, line in enumerate(_read_lines(path), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        try:
            labels.append(_parse_line(text, number, allow_outside))
        except ValueError as error:
            raise RecordingError(
                f"{path}: line {number} is malformed ({one_line(error)}); expected: d alpha w beta"
                " # filename"
            ) from error
    return labels


def write_labels(path: Path, labels: Iterable[Label]) -> None:
    """Write a sequence file; numbers read back are equal to the last bit.

    Raises
    ------
    OutputError
        The file cannot be written, or a name would not be read back as it is.
    """
    try:
        with path.open("w", encoding="utf-8", newline="\n") as file:
            file.write(format_labels(labels))
    except ValueError as error:
        raise OutputError(f"{path}: cannot be written ({error}); rename the recording") from error
    except OSError as error:
        raise write_failure(path, error) from error


def format_labels(labels: Iterable[Label], *, allow_outside: bool = False) -> str:
    """Return the text of a sequence file.

    Raises
    ------
    ValueError
        A name would not be read back as it is.
    """
    return _HEADER + "".join(_format_label(label, allow_outside) for label in labels)


def _format_label(label: Label, allow_outside: bool) -> str:
    state, name = label.state, str(label)
    if not is_usable(label):
        raise ValueError(f"{name!r} is no usable file name")
    _check_name(label.filename, allow_outside)
    _check_video(label)
    numbers = " ".join(repr(v) for v in (state.distance, state.angle, state.width, state.skew))
    return f"{numbers} # {name}\n"


def is_usable(frame_name: FrameName) -> bool:
    """Tell whether a label file can name a frame in such a way that it is read back as it is."""
    name = str(frame_name)
    is_read_back = parse_name(name.strip()) == FrameName(frame_name.filename, frame_name.frame)
    return bool(name) and is_read_back and not _breaks_a_line(name)


def _breaks_a_line(name: str) -> bool:
    """Tell whether a name holds line breaks, control characters, or half of a character.

    Blanks of any kind do no harm: names of screen recordings have such as do not break.
    """
    return any(unicodedata.category(character) in {"Cc", "Cs", "Zl", "Zp"} for character in name)


def _resolve(sequence: Path, label: Label, allow_outside: bool) -> Path:
    """Return the file of a label; refuse what a link would take out of the folder."""
    folder = sequence.parent.resolve()
    try:
        file = (folder / label.filename).resolve()
    except (OSError, RuntimeError) as error:
        raise RecordingError(
            f"{sequence}: {label.filename} cannot be followed; check the links on its way"
        ) from error
    if not (allow_outside or file.is_relative_to(folder)):
        raise RecordingError(
            f"{sequence}: {label.filename} leads outside the folder of the sequence file; a file"
            " that you trust may do that with --allow-outside (node: allow_outside)"
        )
    if not file.is_file():
        raise RecordingError(f"{sequence}: {label.filename} is missing; put it beside the file")
    return file


def _check_kind(sequence: Path, label: Label) -> None:
    if label.frame is not None and not label.filename.lower().endswith(VIDEO_SUFFIXES):
        raise RecordingError(f"{sequence}: {label} asks for a frame of a file that is no video")


def _one_pass(labels: list[Label]) -> Iterator[list[Label]]:
    """Split labels into runs that can be read from one file in one pass."""
    if not labels:
        return
    run = labels[:1]
    for before, label in pairwise(labels):
        same_file = before.filename == label.filename
        if (
            not same_file
            or before.frame is None
            or label.frame is None
            or (label.frame <= before.frame)
        ):
            yield run
            run = []
        run.append(label)
    yield run


class SequenceFileSource(Source):
    """The frames that a sequence file lists, in its order, all of them with ground truth.

    The time of a frame of a video is the one it has in the video, see `VideoSource`; of a picture
    its place in the list over `rate`; both counted from `FIRST_STAMP`. Pictures that are numbered
    with gaps keep the times that their numbers say. Each further file begins `APART` later: what is
    in one is not followed into another.

    Raises
    ------
    RecordingError
        The file is malformed, or a picture or video it names is missing or lies outside its folder.
    """

    def __init__(self, chosen: ChosenRecording) -> None:
        super().__init__(chosen)
        path, allow_outside = chosen.path, chosen.allow_outside
        self._entries = read_labels(path, allow_outside=allow_outside)
        self._rate = chosen.rate or USUAL_RATE
        for label in self._entries:
            _check_kind(path, label)
        self._files = {
            label.filename: _resolve(path, label, allow_outside) for label in self._entries
        }
        self._with_steady_rate = {
            name
            for name, file in self._files.items()
            if name.lower().endswith(VIDEO_SUFFIXES) and times_run_backwards(file)
        }
        names = [label.filename for label in self._entries if label.frame is None]
        count = len(self._entries)
        self._positions = positions_by_number(names) if len(names) == count else list(range(count))
        videos = dict.fromkeys(label.filename for label in self._entries if label.frame is not None)
        self._begins = {name: APART * k for k, name in enumerate(videos, bool(names))}
        self.taken_rate = self._rate if names else None
        self.note = "; ".join(self._notes(names))
        self.frame_count = count
        self.has_truth = True

    def _notes(self, names: list[str]) -> Iterator[str]:
        """Say what the user should know of its times; `names` of its pictures."""
        for name in sorted(self._with_steady_rate):
            yield f"{name}: {TIMES_NOTE}"
        if gaps := gap_note(names, self._positions):
            yield f"numbered with gaps: {gaps}"
        if len(self._begins) > 1 or (self._begins and names):
            yield f"holds several recordings; each begins {APART / NANOSECONDS:g} s after the other"

    @property
    def entries(self) -> tuple[Label, ...]:
        """Entries of the file: entry i is frame i."""
        return tuple(self._entries)

    def frame_name(self, index: int) -> str:
        """Return the name of a frame for messages to the user."""
        return f"frame {index} ({self._entries[index]})"

    def _read(self, start: int) -> Generator[Frame]:
        first = start
        for labels in _one_pass(self._entries[start:]):
            if labels[0].frame is None:
                yield self._picture(first, labels[0])
            else:
                yield from self._video_frames(first, labels)
            first += len(labels)

    def _picture(self, index: int, label: Label) -> Frame:
        stamp = stamp_of_frame(self._positions[index], self._rate)
        try:
            image = load_picture(self._files[label.filename])
        except FrameError as error:
            return Frame(index, stamp, missing_image(str(error)), truth=label.state)
        return Frame(index, stamp, image, truth=label.state)

    def _video_frames(self, start: int, labels: list[Label]) -> Generator[Frame]:
        with opened_video(self._files[labels[0].filename]) as container:
            frames = VideoFrames(
                container, has_steady_rate=labels[0].filename in self._with_steady_rate
            )
            number = frames.pass_over(labels[0].frame or 0) - 1
            for index, label in enumerate(labels, start):
                picture = None
                while label.frame is not None and number < label.frame:
                    picture = frames.next_picture()
                    number += 1
                    if picture is None:
                        fault = f"has a frame {number} that cannot be decoded: {frames.fault}"
                        end = fault if frames.fault else f"has only {number} frames"
                        raise damage(self.path, index, f"{label.filename} {end}")
                if picture is not None:
                    image = raw_from_array(picture, "bgr8")
                    stamp = self._begins[label.filename] + frames.stamp
                    yield Frame(index, stamp, image, truth=label.state)
