"""Borders and centreline of a cable for rviz."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import project_borders, segment_inside
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
        borders = project_borders(state.to_array()[None, :])
        both = zip(borders.angles[0], borders.offsets[0], strict=True)
        drawn += [
            Lines("borders", _lines_inside(list(both), image_size), GREEN),
            Lines("centreline", _lines_inside([(state.angle, state.distance)], image_size), AMBER),
        ]
    return make_line_markers(factory, header, drawn)


def _lines_inside(lines: list[tuple[float, float]], image_size: tuple[int, int]) -> FloatArray:
    """Return the ends of lines (angle [rad], offset [px]) in the image; (0, 2) if none is there."""
    ends = [
        end for angle, offset in lines for end in segment_inside(angle, offset, image_size) or ()
    ]
    return np.array(ends, dtype=np.float64).reshape(-1, 2)


def _pixel_corners(image_size: tuple[int, int]) -> FloatArray:
    """Return the centres of the corner pixels, shape (4, 2) [px]."""
    x, y = (image_size[0] - 1) / 2, (image_size[1] - 1) / 2
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
