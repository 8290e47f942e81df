"""Frames of an opened video, and their times: the container's, unless a steady rate fits them."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import accumulate, islice, pairwise
from pathlib import Path

import av
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError
from av.video.reformatter import Interpolation, VideoReformatter

from cable_tracker.arrays import Image
from cable_tracker.errors import RecordingError, read_failure
from cable_tracker.sequences.pictures.picture_header import MAX_PIXELS
from cable_tracker.stamps import FIRST_STAMP, NANOSECONDS, USUAL_RATE, stamp_of_frame

_HIGHEST_RATE = 1000.0

_LONGEST_WAIT = 30.0
"""Opening a file, and reading a packet of it, may take so long [s]."""

PROBED_PACKETS = 250
"""Number of packets that show whether a container's times can be used: ten seconds, a few MB."""

_MOST_REORDERED = 16
"""No codec shows a frame before one that is coded more frames earlier."""

_LEAST_STEP = 0.0005
"""Times that are closer count as the same [s]."""

ROUNDING = 2_000_000
"""Containers round times to a millisecond, some to 1/600 s; what differs by less is steady [ns]."""

LONGEST_GAP = 86_400 * NANOSECONDS
"""No recorder pauses longer within a file; a time further ahead is damage [ns]."""


def ffmpeg_name(path: Path) -> str:
    """Return a name under which FFmpeg finds a file.

    What stands before a colon it takes for a protocol, as in `http:`, unless a slash stands before
    it; recorders write times such as 12:30:00 into names.
    """
    return os.path.join(os.curdir, path)  # noqa: PTH118


@contextmanager
def opened_video(path: Path) -> Iterator[InputContainer]:
    """Open a file whose first stream of pictures can be decoded, and close it at the end.

    Raises
    ------
    RecordingError
        The file is missing, empty, no video, one of more than `MAX_PIXELS` pixels, or one whose
        name is not UTF-8.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise read_failure(path, error) from error
    if not size:
        raise RecordingError(f"{path}: the file is empty; record or copy it again")
    _need_utf8_name(path)
    try:
        # Tags of a file may be no text.
        container = av.open(ffmpeg_name(path), metadata_errors="replace", timeout=_LONGEST_WAIT)
    except FFmpegError as error:
        raise _no_video(path) from error
    with container:
        _prepare_stream(path, container)
        yield container


def _need_utf8_name(path: Path) -> None:
    """Refuse a name that is not UTF-8: FFmpeg is given names in it."""
    name = str(path)
    if name != name.encode(errors="replace").decode():
        raise RecordingError(
            f"{path}: a video whose path is not UTF-8 cannot be opened; rename the file or folder,"
            " for example with convmv"
        )


def _no_video(path: Path) -> RecordingError:
    return RecordingError(
        f"{path}: no video can be read from it; it is damaged, truncated, or not a video;"
        " copy it again"
    )


def _prepare_stream(path: Path, container: InputContainer) -> None:
    """Refuse what cannot be decoded or takes gigabytes to decode, before it is decoded."""
    streams = container.streams.video
    # Typed as if there always were one; of an unknown coding there is none.
    if not streams or streams[0].codec_context is None:
        raise _no_video(path)
    stream = streams[0]
    if stream.width * stream.height > MAX_PIXELS:
        raise RecordingError(
            f"{path}: a video of {stream.width} x {stream.height} pixels, more than the"
            f" {MAX_PIXELS} allowed; make a smaller one of it"
        )
    # A later frame may claim another size than the header.
    stream.codec_context.options = {"max_pixels": str(MAX_PIXELS)}
    stream.thread_type = "AUTO"


def frame_rate(stream: av.VideoStream) -> float:
    """Return the frames per second of a video, the usual ones where it does not say."""
    rate = float(stream.guessed_rate or 0)
    return rate if 0.0 < rate <= _HIGHEST_RATE else USUAL_RATE


def decoded_frames(
    stream: av.VideoStream, packets: Iterable[av.Packet[av.VideoStream]]
) -> Iterator[av.VideoFrame]:
    """Yield what can be decoded of some packets, in the order in which it is shown.

    Raises
    ------
    FFmpegError
        A packet cannot be decoded: what follows would have numbers of frames before it.
    """
    for packet in _readable(packets):
        yield from stream.codec_context.decode(packet)


def _readable(
    packets: Iterable[av.Packet[av.VideoStream]],
) -> Iterator[av.Packet[av.VideoStream] | None]:
    """Yield packets up to where the file cannot be read on, then None: the decoder's last call."""
    with suppress(FFmpegError):
        for packet in packets:
            # To a decoder one without data is the end of the stream.
            if packet.size:
                yield packet
    yield None


def times_run_backwards(path: Path) -> bool:
    """Tell whether the times at the beginning of a video repeat or run backwards.

    Its packets are looked at, not decoded. A file that cannot be read has no times.
    """
    try:
        with opened_video(path) as container:
            packets = islice(container.demux(video=0), PROBED_PACKETS)
            times = [
                float(packet.pts * packet.time_base)
                for packet in packets
                if packet.pts is not None and packet.time_base is not None
            ]
    except (FFmpegError, RecordingError):
        # Opening it to read its frames says what is wrong with it.
        return False
    latest = accumulate(times, max)
    if any(time < before for time, before in zip(times[_MOST_REORDERED:], latest, strict=False)):
        return True
    return any(after - before < _LEAST_STEP for before, after in pairwise(sorted(times)))


class PacketTally:
    """Counts the packets of a stream while they are read.

    Attributes
    ----------
    discarded : int
        Number of packets that only serve to decode others: a file that was cut without coding it
        anew says with an edit list where the first frame that is shown begins.
    end : int or None
        Latest end of a packet, in ticks of the stream; None: none has a time.
    """

    def __init__(self) -> None:
        self.discarded = 0
        self.end: int | None = None
        self._numbered = 0
        self._last_number = -1

    def counted(self, packet: av.Packet[av.VideoStream]) -> av.Packet[av.VideoStream]:
        """Count a packet, and return it."""
        self.discarded += packet.is_discard
        if packet.pts is not None:
            end = packet.pts + (packet.duration or 0)
            self.end = end if self.end is None else max(self.end, end)
        if packet.dts is not None:
            self._numbered += 1
            self._last_number = max(self._last_number, packet.dts)
        return packet

    @property
    def empty(self) -> int:
        """Number of packets without data before the last one of an AVI, which numbers them.

        FFmpeg passes over these, but the header counts them. What is missing behind the last packet
        is not taken for a pause: a file that was cut off looks alike.
        """
        return self._last_number + 1 - self._numbered


class VideoFrames:
    """The frames of an opened video, one after the other, with their times.

    Parameters
    ----------
    container : InputContainer
        The video, at its beginning.
    has_steady_rate : bool
        Whether the times of the container are not to be used.

    Attributes
    ----------
    stamp : int
        Time of the frame that was read last [ns], whether its pixels were converted or not.
    fault : str
        Reason why a frame cannot be decoded, behind which none is read; empty: there is none.
    tally : PacketTally
        What has been read of the file for these frames.
    """

    def __init__(self, container: InputContainer, *, has_steady_rate: bool) -> None:
        self._stream = container.streams.video[0]
        self.fault = ""
        self.tally = PacketTally()
        self._frames = decoded_frames(
            self._stream, map(self.tally.counted, container.demux(self._stream))
        )
        self._converter = VideoReformatter()
        self._clock = FrameClock(frame_rate(self._stream), is_steady=has_steady_rate)
        self.stamp = FIRST_STAMP

    def next_picture(self) -> Image | None:
        """Decode the next frame, shape (H, W, 3), uint8, blue-green-red; None at the end.

        It is as it is stored, also where players turn it: so are pictures read, to which labels and
        calibrations refer.
        """
        frame = self._next_frame()
        if frame is None:
            return None
        try:
            converted = self._converter.reformat(
                frame, format="bgr24", interpolation=Interpolation.BICUBIC, threads=1
            )
        except FFmpegError as error:
            self.fault = error.strerror or str(error)
            return None
        return np.asarray(converted.to_ndarray(), np.uint8)

    def pass_over(self, count: int) -> int:
        """Go past frames without converting their pixels; return how many there were."""
        return sum(self._next_frame() is not None for _ in range(count))

    def _next_frame(self) -> av.VideoFrame | None:
        try:
            frame = next(self._frames, None)
        except FFmpegError as error:
            self.fault = error.strerror or str(error)
            return None
        if frame is not None:
            self.stamp = self._clock.next_stamp(self._time(frame))
        return frame

    def _time(self, frame: av.VideoFrame) -> float:
        """Return the time of a frame since the beginning of the stream [ms]; NaN: it has none."""
        ticks = frame.dts if frame.pts is None else frame.pts
        if ticks is None or not self._stream.time_base:
            return math.nan
        return float(1000 * (ticks - (self._stream.start_time or 0)) * self._stream.time_base)


class FrameClock:
    """Gives the frames of a video their stamps, one after the other.

    They are those of a steady rate as long as the container's times agree with it to within their
    rounding; where they do not, the container's time is taken, and the rate goes on from there. A
    time that does not come after that of the frame before is not believed.

    Parameters
    ----------
    rate : float
        Frames per second.
    is_steady : bool
        Whether the container's times are not to be used at all.
    """

    def __init__(self, rate: float, *, is_steady: bool = False) -> None:
        self._rate = rate
        self._is_steady = is_steady
        self._rounding = min(ROUNDING, NANOSECONDS / rate / 2)
        self._index = -1
        self._first_time = 0.0
        self._anchor, self._anchor_stamp = 0, FIRST_STAMP
        self._last = FIRST_STAMP

    def next_stamp(self, container_time: float) -> int:
        """Return the stamp of the next frame [ns].

        Parameters
        ----------
        container_time : float
            Time of the frame according to the container [ms], NaN where it has none; of the first
            one that is the beginning, 0.
        """
        self._index += 1
        if not self._index:
            self._first_time = container_time if math.isfinite(container_time) else 0.0
        steady = stamp_of_frame(self._index - self._anchor, self._rate)
        self._last = self._corrected(steady - FIRST_STAMP + self._anchor_stamp, container_time)
        return self._last

    def _corrected(self, steady: int, container_time: float) -> int:
        """Return the stamp of a frame [ns], and go on from it where it is not the steady one."""
        after_first = container_time - self._first_time
        if self._is_steady or not math.isfinite(after_first):
            return steady
        stamp = FIRST_STAMP + round(after_first * 1e6)
        if abs(stamp - steady) <= self._rounding or not 0 < stamp - self._last <= LONGEST_GAP:
            return steady
        self._anchor, self._anchor_stamp = self._index, stamp
        return stamp
