"""Contour and box of a target for rviz."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message, MessageFactory
from cable_tracker.sequences.messages.line_markers import (
    AMBER,
    GREEN,
    GREY,
    Lines,
    make_line_markers,
    sides_of_polygon,
)
from cable_tracker.target.model.estimate import TargetEstimate, box_corners
from cable_tracker.tracking.image_frame import from_page


def make_target_markers(
    factory: MessageFactory, header: Message, estimate: TargetEstimate
) -> Message:
    """Pack contour, box and image frame as a MarkerArray, 0.01 m to the pixel, y up.

    Without a claim the lines of before are deleted.
    """
    size = estimate.image_size
    drawn = [Lines("image", _sides(box_corners((0.0, 0.0, *size)), size), GREY)]
    if estimate.is_claimed:
        assert estimate.box is not None
        drawn.append(Lines("box", _sides(box_corners(estimate.box), size), GREEN))
        if len(estimate.outline):
            drawn.append(Lines("contour", _sides(estimate.outline, size), AMBER))
    return make_line_markers(factory, header, drawn)


def _sides(corners: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return the ends of the sides of a polygon (K, 2) that counts from the top left, (2K, 2)."""
    return sides_of_polygon(np.column_stack(from_page(corners[:, 0], corners[:, 1], image_size)))
