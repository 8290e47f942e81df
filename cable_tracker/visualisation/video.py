"""Overlay videos that a web browser plays, drawn and encoded beside the tracking in a thread."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from queue import Queue
from threading import Thread
from types import TracebackType
from typing import Final, Self, TypeAlias

import av
import cv2
import numpy as np
from av.container import OutputContainer
from av.video.stream import VideoStream

from cable_tracker.arrays import Image
from cable_tracker.atomic_output import AtomicFile
from cable_tracker.errors import OutputError, write_failure
from cable_tracker.sequences.videos.video_frames import ffmpeg_name
from cable_tracker.stamps import NANOSECONDS

TICKS = 1000
"""Time stamps of the file per second: WebM counts milliseconds."""

USUAL_STEP = 40_000_000
"""Time to the next frame where the stamps do not give it [ns]."""

LONGEST_STEP = 10_000_000_000
"""A longer pause between two stamps is not shown in full, but as a usual step [ns]."""

CONTAINER_OPTIONS = {"fflags": "+bitexact"}
"""Options of the container; without them each file gets a random number of its own, but equal
frames must give equal files."""

CODEC: Final = "libvpx"
"""VP8: takes half of the time that VP9 takes, and browsers play both."""

CODEC_OPTIONS = {"deadline": "realtime", "cpu-used": "16", "crf": "20", "b": "4M"}
"""`crf` is the quality to reach, and `b` the most bits a second that it may take."""

CODEC_THREADS = 1
"""Number of threads of the codec; more share a frame's time only when nothing else computes, and
take more of it in all."""

Job: TypeAlias = Callable[[], None]

CAPACITY = 8
"""Jobs that may wait, so that memory stays bounded: each holds a frame."""


def next_step(previous: int, stamp: int, usual: int) -> int:
    """Return the duration for which a frame is shown [ns].

    Parameters
    ----------
    previous, stamp : int
        Stamps of the frame and of the one after it [ns].
    usual : int
        What is returned where the second stamp is not later than the first, or so much later that
        the video would stand still [ns].
    """
    step = stamp - previous
    return step if 0 < step <= LONGEST_STEP else usual


class VideoWriter:
    """Writes frames with their time stamps to a WebM file (VP8).

    A context manager. The file appears under its name when the block ends well; after an error
    nothing is left behind. All frames get the size of the first, padded to even numbers.

    Parameters
    ----------
    path : Path
        File to write; an existing one is replaced.

    Raises
    ------
    OutputError
        The file cannot be written, or (at the end) no frame was added.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = AtomicFile(path)
        self._container: OutputContainer | None = None
        self._stream: VideoStream | None = None
        self._size = (0, 0)
        self._frame_count = 0
        self._last_stamp = 0
        self._usual_step = USUAL_STEP
        self._elapsed = 0
        self._last_tick = -1

    def __enter__(self) -> VideoWriter:
        try:
            self._file.part.touch()
            self._container = av.open(
                ffmpeg_name(self._file.part), mode="w", format="webm", options=CONTAINER_OPTIONS
            )
        except (OSError, av.error.FFmpegError) as error:
            with contextlib.suppress(OutputError):
                self._discard()
            raise write_failure(self._path, error) from error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            # The error that ended the block says more than one about the unfinished file.
            with contextlib.suppress(OutputError):
                self._discard()
            return
        if self._frame_count == 0:
            self._discard()
            raise OutputError(f"{self._path}: no frames, so no video; check the recording")
        self._finish()

    def add(self, image: Image, stamp: int) -> None:
        """Append a frame.

        A stamp that is not later than the one before, or more than ten seconds later, continues
        the video at its usual pace.

        Parameters
        ----------
        image : Image
            Blue-green-red, uint8, shape (H, W, 3). If its size is not that of the first frame, it
            is fitted into that.
        stamp : int
            Time of the frame [ns].

        Raises
        ------
        OutputError
            The file cannot be written.
        """
        if self._container is None:
            raise OutputError(f"{self._path}: the video is not open; use it in a with statement")
        try:
            if self._stream is None:
                self._stream = self._open_stream(image)
            frame = av.VideoFrame.from_ndarray(self._fit(image), format="bgr24")
            frame.pts = self._tick(stamp)
            frame.time_base = Fraction(1, TICKS)
            self._container.mux(self._stream.encode(frame))
        except (OSError, ValueError, av.error.FFmpegError) as error:
            raise write_failure(self._path, error) from error
        self._frame_count += 1

    def _open_stream(self, image: Image) -> VideoStream:
        assert self._container is not None
        height, width = image.shape[:2]
        self._size = (width + width % 2, height + height % 2)
        stream: VideoStream = self._container.add_stream(
            CODEC, rate=25, options=dict(CODEC_OPTIONS)
        )
        stream.codec_context.thread_count = CODEC_THREADS
        stream.width, stream.height = self._size
        stream.pix_fmt = "yuv420p"
        stream.time_base = Fraction(1, TICKS)
        stream.codec_context.time_base = Fraction(1, TICKS)
        return stream

    def _fit(self, image: Image) -> Image:
        """Bring an image to the size of the video: pad by its last row and column, or letterbox."""
        width, height = self._size
        down, right = height - image.shape[0], width - image.shape[1]
        if down in (0, 1) and right in (0, 1):
            return cv2.copyMakeBorder(image, 0, down, 0, right, cv2.BORDER_REPLICATE)
        scale = min(width / image.shape[1], height / image.shape[0])
        size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
        fitted: Image = np.zeros((height, width, 3), dtype=np.uint8)
        top, left = (height - size[1]) // 2, (width - size[0]) // 2
        fitted[top : top + size[1], left : left + size[0]] = cv2.resize(image, size)
        return fitted

    def _tick(self, stamp: int) -> int:
        """Return the time of the next frame in the file, later than the one before."""
        if self._frame_count > 0:
            step = next_step(self._last_stamp, stamp, self._usual_step)
            self._elapsed += step
            self._usual_step = step
        self._last_stamp = stamp
        tick = max(round(self._elapsed * TICKS / NANOSECONDS), self._last_tick + 1)
        self._last_tick = tick
        return tick

    def _finish(self) -> None:
        assert self._container is not None
        assert self._stream is not None
        try:
            self._container.mux(self._stream.encode(None))
            self._container.close()
            self._container = None
            self._file.commit()
        except (OSError, av.error.FFmpegError) as error:
            raise write_failure(self._path, error) from error
        finally:
            self._discard()

    def _discard(self) -> None:
        """Close and remove the files that have been written."""
        container, self._container, self._stream = self._container, None, None
        try:
            try:
                if container is not None:
                    container.close()
            finally:
                self._file.discard()
        except (OSError, av.error.FFmpegError) as error:
            raise write_failure(self._path, error) from error


class DrawingThread:
    """Does jobs one after the other in a thread of its own. A context manager.

    When the block ends well, all jobs have been done. When it ends with an exception, those that
    wait are left out.
    """

    def __init__(self) -> None:
        self._jobs: Queue[Job | None] = Queue(CAPACITY)
        self._thread = Thread(target=self._work, name="drawing", daemon=True)
        self._error: BaseException | None = None
        self._abandoned = False

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._abandoned = error is not None
        self._jobs.put(None)
        self._thread.join()
        if error is None:
            self._raise_error()

    def do(self, job: Job) -> None:
        """Have a job done after those before it.

        Raises
        ------
        Exception
            What an earlier job raised.
        """
        self._raise_error()
        self._jobs.put(job)

    def _raise_error(self) -> None:
        if self._error is not None:
            raise self._error

    def _work(self) -> None:
        # Jobs are taken to the end in any case, so that `do` never waits for ever.
        while (job := self._jobs.get()) is not None:
            if self._abandoned or self._error is not None:
                continue
            try:
                job()
            # Told in the thread that gave the job.
            except BaseException as error:  # noqa: BLE001
                self._error = error
