"""Frames as JPEG files for the browser, those that are asked for often kept."""

from __future__ import annotations

import threading
from dataclasses import dataclass

from cable_tracker.errors import FrameError
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.sequences.pictures.shown_levels import decode_shown, stand_in
from cable_tracker.sequences.recently_used import RecentlyUsed

QUALITY = 92
"""Borders must not be moved by blocks of the JPEG."""

KEPT_BYTES = 64 << 20
"""Size of the JPEG files that are kept in memory."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One frame for the browser.

    Attributes
    ----------
    frame : int
        Number of the frame.
    stamp : int
        Time of the frame [ns].
    size : (int, int)
        Width and height [px].
    jpeg : memoryview
        The JPEG file.
    trouble : str
        Reason why the picture cannot be shown; empty if it can.
    """

    frame: int
    stamp: int
    size: tuple[int, int]
    jpeg: memoryview
    trouble: str = ""


class Pictures:
    """Makes pictures of the frames of a recording; from any thread."""

    def __init__(self, access: FrameAccess) -> None:
        self._access = access
        self._kept: RecentlyUsed[Picture] = RecentlyUsed(KEPT_BYTES)
        self._lock = threading.Lock()

    def picture(self, frame: int) -> Picture:
        """Return the picture of a frame.

        Raises
        ------
        IndexError
            The recording ends before it.
        RecordingError
            The recording is damaged before or at it.
        """
        with self._lock:
            kept = self._kept.get(frame)
        if kept is not None:
            return kept
        made = self._make(frame)
        with self._lock:
            self._kept.put(frame, made, len(made.jpeg))
        return made

    def _make(self, number: int) -> Picture:
        frame = self._access.frame(number)
        trouble = ""
        try:
            image = decode_shown(frame.image)
            jpeg = encode_jpeg(image, QUALITY)
        except FrameError as error:
            trouble = str(error)
            image = stand_in()
            jpeg = encode_jpeg(image, QUALITY)
        size = (image.shape[1], image.shape[0])
        return Picture(number, frame.stamp, size, jpeg.data, trouble)
