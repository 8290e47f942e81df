"""A picture of each event of a dive."""

from __future__ import annotations

from pathlib import Path

import cv2

from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.pictures.encoded_pictures import jpeg_bytes
from cable_tracker.sequences.pictures.shown_levels import decode_shown
from cable_tracker.sequences.source_base import Source
from cable_tracker.survey.outputs.surveyed_dive import SurveyedDive

THUMBNAIL = 240
"""Width of the pictures of events [px]."""

JPEG_QUALITY = 75


def write_pictures(recording: Source, folder: Path, surveyed: SurveyedDive) -> None:
    """Keep small pictures of the frames of each event.

    Of its end, too: along the cable the other way that is where it begins.
    """
    events = [*surveyed.events, *(each for placed in surveyed.routes for each in placed.events)]
    wanted = {frame for each in events for frame in (each.frame, each.end_frame) if frame >= 0}
    if not wanted:
        return
    folder.mkdir(exist_ok=True)
    last = max(wanted)
    try:
        for frame in recording.frames(min(wanted)):
            if frame.index in wanted:
                _write_thumbnail(folder / f"{frame.index}.jpg", frame)
            if frame.index >= last:
                return
    except RecordingError:
        # Where it breaks off stands in the notes already.
        return


def _write_thumbnail(path: Path, frame: Frame) -> None:
    """Write a small picture of a frame; nothing if it cannot be decoded."""
    try:
        picture = decode_shown(frame.image)
    except FrameError:
        return
    height = max(1, round(picture.shape[0] * THUMBNAIL / picture.shape[1]))
    small = cv2.resize(picture, (THUMBNAIL, height), interpolation=cv2.INTER_AREA)
    path.write_bytes(jpeg_bytes(small, JPEG_QUALITY))
