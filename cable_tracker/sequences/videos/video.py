"""Video files as recordings."""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Iterable, Iterator
from itertools import islice
from pathlib import Path

import av
from av.container import InputContainer
from av.error import FFmpegError

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame, missing_image
from cable_tracker.sequences.source_base import ChosenRecording, Source, damage
from cable_tracker.sequences.videos.video_frames import (
    PROBED_PACKETS,
    PacketTally,
    VideoFrames,
    decoded_frames,
    frame_rate,
    opened_video,
    times_run_backwards,
)

VIDEO_SUFFIXES = (".mp4", ".avi", ".mkv", ".mov", ".webm", ".mpg", ".m4v", ".ts")

_COUNTED_SUFFIXES = (".mp4", ".m4v", ".mov", ".avi")
"""Containers that store their number of frames; for the others FFmpeg only guesses it."""

_TIMED_SUFFIXES = (".mkv", ".webm")
"""Containers whose header says how long their streams are."""

_LEAST_MISSING = 1.0
"""What a file ends before its time by is missing from this on [s]."""

TIMES_NOTE = (
    "its times repeat or run backwards and are not used; its frames are taken at its steady rate."
    " If they are not steady, write the video anew with right times"
)
"""What the user should know of a video whose times are not used."""


def _frame_count(path: Path, container: InputContainer) -> int | None:
    """Return the number of frames by a video's header; None where the header is not reliable."""
    if path.suffix.lower() not in _COUNTED_SUFFIXES:
        return None
    stream = container.streams.video[0]
    seconds = (container.duration or 0) / av.time_base
    count = stream.frames or math.floor(seconds * frame_rate(stream) + 0.5)
    return count if count > 0 else None


def _turn(container: InputContainer) -> int:
    """Return by how many degrees players turn the pictures clockwise; the first one tells it."""
    stream = container.streams.video[0]
    packets = islice(container.demux(stream), PROBED_PACKETS)
    try:
        first = next(decoded_frames(stream, _up_to_shown(packets)), None)
    except FFmpegError:
        # Reading the frames says what is wrong with it.
        return 0
    return 0 if first is None else -first.rotation % 360


def _up_to_shown(
    packets: Iterable[av.Packet[av.VideoStream]],
) -> Iterator[av.Packet[av.VideoStream]]:
    """Yield packets up to the first one whose picture is shown."""
    for packet in packets:
        yield packet
        if not packet.is_discard:
            return


def _misses_frames(path: Path, frame_count: int | None, count: int, tally: PacketTally) -> bool:
    """Tell whether a file has given fewer frames than its header says."""
    empty = tally.empty if path.suffix.lower() == ".avi" else 0
    return count < (frame_count or 1) - tally.discarded - empty


def _missing_seconds(path: Path, stream: av.VideoStream, tally: PacketTally) -> float | None:
    """Return how long a file's pictures should last, if they end long before; else None [s].

    A file that another program is still writing does not say how long it will be.
    """
    if path.suffix.lower() not in _TIMED_SUFFIXES or tally.end is None or not stream.time_base:
        return None
    # The file may hold sound that lasts longer.
    promised = _seconds(stream.metadata.get("DURATION", ""))
    if promised is None or float(tally.end * stream.time_base) >= promised - _LEAST_MISSING:
        return None
    return promised


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

    def __init__(self, chosen: ChosenRecording) -> None:
        super().__init__(chosen)
        path = chosen.path
        with opened_video(path) as container:
            self.frame_count = _frame_count(path, container)
            turn = _turn(container)
        self._has_steady_rate = times_run_backwards(path)
        notes = [TIMES_NOTE] if self._has_steady_rate else []
        if turn:
            notes.append(f"players turn it by {turn} degrees; it is read as it is stored")
        self.note = "; ".join(notes)

    def _read(self, start: int) -> Generator[Frame]:
        with opened_video(self.path) as container:
            # Jumping to a frame by its number lands beside it in many files.
            frames = VideoFrames(container, has_steady_rate=self._has_steady_rate)
            count = frames.pass_over(start)
            while (picture := frames.next_picture()) is not None:
                yield self._frame(count, frames.stamp, picture)
                count += 1
            seconds = _missing_seconds(self.path, container.streams.video[0], frames.tally)
        reasons = []
        if frames.fault:
            reasons.append(f"the next one cannot be decoded: {frames.fault}")
        if _misses_frames(self.path, self.frame_count, count, frames.tally):
            reasons.append(f"the file promises {self.frame_count or 'some'}")
        if seconds is not None:
            reasons.append(f"the file promises {seconds:.1f} s of them")
        if reasons:
            raise damage(self.path, count, "; ".join(reasons))

    @staticmethod
    def _frame(index: int, stamp: int, picture: Image) -> Frame:
        try:
            return Frame(index, stamp, raw_from_array(picture, "bgr8"))
        except FrameError as error:
            return Frame(index, stamp, missing_image(str(error)))
