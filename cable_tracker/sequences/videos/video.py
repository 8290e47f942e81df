"""Frames of video files."""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import av
import cv2
import numpy as np
from av.error import FFmpegError

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError, RecordingError, read_failure
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.opencv_quiet import silence_opencv
from cable_tracker.sequences.pictures.picture_header import MAX_PIXELS
from cable_tracker.sequences.source_base import Source, UnreadableFrame, damage
from cable_tracker.sequences.videos.ffmpeg_names import ffmpeg_name
from cable_tracker.sequences.videos.video_times import FrameClock, times_run_backwards
from cable_tracker.stamps import FIRST_STAMP, USUAL_RATE

VIDEO_SUFFIXES = (".mp4", ".avi", ".mkv", ".mov", ".webm", ".mpg", ".m4v", ".ts")

_COUNTED_SUFFIXES = (".mp4", ".m4v", ".mov", ".avi")
"""Containers that store their number of frames; for the others FFmpeg only guesses it."""

_TIMED_SUFFIXES = (".mkv", ".webm")
"""Containers whose header says how long their streams are."""

_LEAST_MISSING = 1.0
"""What a file ends before its time by is missing from this on [s]."""

_HIGHEST_RATE = 1000.0

TIMES_NOTE = (
    "its times repeat or run backwards and are not used; its frames are taken at its steady rate."
    " If they are not steady, write the video anew with right times"
)
"""What the user should know of a video whose times are not used."""


@contextmanager
def opened_video(path: Path) -> Iterator[cv2.VideoCapture]:
    """Open a video, and release it at the end.

    Raises
    ------
    RecordingError
        The file is missing, empty, no video, one of more than `MAX_PIXELS` pixels, or one whose
        name is not UTF-8.
    """
    silence_opencv()
    try:
        size = path.stat().st_size
    except OSError as error:
        raise read_failure(path, error) from error
    if not size:
        raise RecordingError(f"{path}: the file is empty; record or copy it again")
    _need_utf8_name(path)
    capture = cv2.VideoCapture(ffmpeg_name(path), cv2.CAP_FFMPEG)
    try:
        if not capture.isOpened():
            raise RecordingError(
                f"{path}: no video can be read from it; it is damaged, truncated, or not a video;"
                " copy it again"
            )
        _need_bounded_size(path, capture)
        # As pictures are read, to which labels and calibrations refer: as they are stored.
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        yield capture
    finally:
        capture.release()


def _need_utf8_name(path: Path) -> None:
    """Refuse a name that is not UTF-8: with such a one OpenCV ends the process."""
    name = str(path)
    if name != name.encode(errors="replace").decode():
        raise RecordingError(
            f"{path}: a video whose path is not UTF-8 cannot be opened; rename the file or folder,"
            " for example with convmv"
        )


def _need_bounded_size(path: Path, capture: cv2.VideoCapture) -> None:
    """Refuse what takes gigabytes to decode, before it is decoded."""
    width = capture.get(cv2.CAP_PROP_FRAME_WIDTH)
    height = capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
    if width * height > MAX_PIXELS:
        raise RecordingError(
            f"{path}: a video of {width:.0f} x {height:.0f} pixels, more than the {MAX_PIXELS}"
            " allowed; make a smaller one of it"
        )


def _frame_rate(capture: cv2.VideoCapture) -> float:
    """Return the frames per second of a video, the usual ones where it does not say."""
    rate = float(capture.get(cv2.CAP_PROP_FPS))
    return rate if math.isfinite(rate) and 0.0 < rate <= _HIGHEST_RATE else USUAL_RATE


def _frame_count(path: Path, capture: cv2.VideoCapture) -> int | None:
    count = float(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    counted = path.suffix.lower() in _COUNTED_SUFFIXES
    return int(count) if counted and math.isfinite(count) and count > 0 else None


class VideoFrames:
    """The frames of an opened video, one after the other, with their times.

    Parameters
    ----------
    capture : cv2.VideoCapture
        The video, at its beginning.
    has_steady_rate : bool
        Whether the times of the container are not to be used.

    Attributes
    ----------
    stamp : int
        Time of the frame that was read last [ns], whether its pixels were converted or not.
    """

    def __init__(self, capture: cv2.VideoCapture, *, has_steady_rate: bool) -> None:
        self._capture = capture
        self._clock = FrameClock(_frame_rate(capture), is_steady=has_steady_rate)
        self.stamp = FIRST_STAMP

    def next_picture(self) -> Image | None:
        """Decode the next frame, shape (H, W, 3), uint8, blue-green-red; None at the end."""
        try:
            decoded, picture = self._capture.read()
        except cv2.error:
            return None
        if not decoded or picture is None:
            return None
        self._tick()
        return np.asarray(picture)

    def pass_over(self, count: int) -> int:
        """Go past frames without converting their pixels; return how many there were."""
        for number in range(count):
            try:
                if not self._capture.grab():
                    return number
            except cv2.error:
                return number
            self._tick()
        return count

    def _tick(self) -> None:
        self.stamp = self._clock.next_stamp(float(self._capture.get(cv2.CAP_PROP_POS_MSEC)))


def _frames_not_shown(path: Path) -> int:
    """Return how many frames a file holds only so that others can be decoded.

    The header counts them. A file that was cut without coding it anew says with an edit list where
    the first frame that is shown begins.
    """
    try:
        # Tags of a file may be no text.
        with av.open(ffmpeg_name(path), metadata_errors="replace") as container:
            packets = [(packet.is_discard, packet.dts) for packet in container.demux(video=0)]
    except (FFmpegError, IndexError):
        # It finds no stream of pictures; then the header is all that is known.
        return 0
    left_out = sum(is_discarded for is_discarded, _ in packets)
    if path.suffix.lower() == ".avi":
        # FFmpeg passes over those without data, but counts them. What is missing behind the last
        # frame is not taken for a pause: a file that was cut off looks alike.
        numbers = [number for _, number in packets if number is not None]
        left_out += max(numbers, default=-1) + 1 - len(numbers)
    return left_out


def _promised_seconds(path: Path) -> float | None:
    """Return how long a file's pictures should last, if they end long before; else None [s].

    A file that another program is still writing does not say how long it will be.
    """
    if path.suffix.lower() not in _TIMED_SUFFIXES:
        return None
    try:
        with av.open(ffmpeg_name(path), metadata_errors="replace") as container:
            (stream,) = container.streams.video[:1]
            # The file may hold sound that lasts longer.
            promised = _seconds(stream.metadata.get("DURATION", ""))
            if promised is None:
                return None
            # Of a whole file only what follows the last key frame is read again.
            with suppress(FFmpegError):
                container.seek(round(promised * av.time_base))
            ends = [
                float((packet.pts + (packet.duration or 0)) * packet.time_base)
                for packet in container.demux(stream)
                if packet.pts is not None and packet.time_base is not None
            ]
    except (FFmpegError, ValueError):
        # It finds no stream of pictures; then what OpenCV reads is all that is known.
        return None
    return promised if ends and max(ends) < promised - _LEAST_MISSING else None


def _seconds(clock: str) -> float | None:
    """Return the seconds of a text such as 01:02:03.5; None if it is no such text."""
    found = re.fullmatch(r"(\d+):(\d+):(\d+(?:\.\d*)?)", clock)
    if found is None:
        return None
    hours, minutes, seconds = map(float, found.groups())
    return 3600.0 * hours + 60.0 * minutes + seconds


class VideoSource(Source):
    """All frames of a video file, as bgr8; their times are the container's, from `FIRST_STAMP` on.

    Where these are those of a steady rate but for rounding, it is that rate's; see `FrameClock`.

    Raises
    ------
    RecordingError
        The file is missing or no video.
    """

    def __init__(self, path: Path, *, skip_bad_frames: bool = False) -> None:
        super().__init__(path, skip_bad_frames=skip_bad_frames)
        with opened_video(path) as capture:
            self.frame_count = _frame_count(path, capture)
            turn = capture.get(cv2.CAP_PROP_ORIENTATION_META)
        self._has_steady_rate = times_run_backwards(path)
        notes = [TIMES_NOTE] if self._has_steady_rate else []
        if turn:
            notes.append(f"players turn it by {turn:g} degrees; it is read as it is stored")
        self.note = "; ".join(notes)

    def _read(self, start: int) -> Generator[Frame | UnreadableFrame]:
        with opened_video(self.path) as capture:
            # Jumping to a frame by its number lands beside it in many files.
            frames = VideoFrames(capture, has_steady_rate=self._has_steady_rate)
            count = frames.pass_over(start)
            while (picture := frames.next_picture()) is not None:
                yield self._frame(count, frames.stamp, picture)
                count += 1
        promised = self.frame_count or 1
        if count < promised and count < promised - _frames_not_shown(self.path):
            raise damage(self.path, count, f"the file promises {self.frame_count or 'some'}")
        if (seconds := _promised_seconds(self.path)) is not None:
            raise damage(self.path, count, f"the file promises {seconds:.1f} s of them")

    @staticmethod
    def _frame(index: int, stamp: int, picture: Image) -> Frame | UnreadableFrame:
        try:
            return Frame(index, stamp, raw_from_array(picture, "bgr8"))
        except FrameError as error:
            return UnreadableFrame(index, stamp, str(error))
