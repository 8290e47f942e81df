"""Keep OpenCV and the FFmpeg inside it from writing to stderr on their own."""

from __future__ import annotations

import os
from functools import cache
from typing import Any, cast

import cv2

_SILENT = 0
_FFMPEG_QUIET = "-8"


@cache
def silence_opencv() -> None:
    """Switch off OpenCV's own messages; what goes wrong is said in our exceptions.

    FFmpeg's level is read from the environment when the first video is opened, so this must be
    called before. A level the user has set there is left alone.
    """
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", _FFMPEG_QUIET)
    # OpenCV 4 has cv2.setLogLevel, OpenCV 5 only cv2.utils.logging.
    opencv = cast("Any", cv2)
    if hasattr(opencv, "setLogLevel"):
        opencv.setLogLevel(_SILENT)
    else:
        opencv.utils.logging.setLogLevel(_SILENT)
