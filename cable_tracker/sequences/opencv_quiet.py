"""Keep OpenCV from writing to stderr on its own."""

from __future__ import annotations

from functools import cache
from typing import Any, cast

import cv2

_SILENT = 0


@cache
def silence_opencv() -> None:
    """Switch off OpenCV's own messages; what goes wrong is said in our exceptions."""
    # OpenCV 4 has cv2.setLogLevel, OpenCV 5 only cv2.utils.logging.
    opencv = cast("Any", cv2)
    if hasattr(opencv, "setLogLevel"):
        opencv.setLogLevel(_SILENT)
    else:
        opencv.utils.logging.setLogLevel(_SILENT)
