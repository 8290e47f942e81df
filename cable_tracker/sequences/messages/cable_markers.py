"""Borders and centreline of a cable for rviz."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.segments import Segment, border_segments, centreline_segments
from cable_tracker.cable.model.state import CableState
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.line_markers import (
    AMBER,
    GREEN,
    GREY,
    Lines,
    make_line_markers,
    sides_of_polygon,
)
from cable_tracker.tracking.image_frame import image_centre


def make_markers(
    factory: MessageFactory,
    header: Message,
    state: CableState | None,
    image_size: tuple[int, int],
) -> Message:
    """Pack borders, centreline and image frame as a MarkerArray, 0.01 m to the pixel.

    Without a cable the lines of before are deleted.
    """
    drawn = [Lines("image", sides_of_polygon(_pixel_corners(image_size)), GREY)]
    if state is not None:
        drawn += [
            Lines("borders", _ends(border_segments(state, image_size)), GREEN),
            Lines("centreline", _ends(centreline_segments(state, image_size)), AMBER),
        ]
    return make_line_markers(factory, header, drawn)


def _ends(segments: list[Segment]) -> FloatArray:
    """Return the ends of K segments, one after the other, shape (2K, 2) [px]."""
    return np.array(segments, dtype=np.float64).reshape(-1, 2)


def _pixel_corners(image_size: tuple[int, int]) -> FloatArray:
    """Return the centres of the corner pixels, shape (4, 2) [px]."""
    x, y = image_centre(image_size)
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
