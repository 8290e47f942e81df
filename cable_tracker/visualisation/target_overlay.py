"""Draws the estimate of a target over its frame."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.image_frame import to_pixel
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.overlay import darken, write_line
from cable_tracker.visualisation.palette import AMBER, PARTICLES, status_colour, to_bgr

LEGEND_HEIGHT = 18
"""Height of the line of numbers, at a width of 480 [px]."""


def draw_target(
    image: Image, estimate: TargetEstimate, particles: FloatArray | None, *, line: int = 0
) -> Image:
    """Return a picture with contour, box, particles and numbers.

    The box is drawn only while the target is claimed.

    Parameters
    ----------
    image : Image
        uint8, grey (H, W) or blue-green-red (H, W, 3).
    particles : FloatArray or None
        Poses in pixels of the frame, shape (N, 6).
    line : int
        Line of the legend, from the top; of several targets each has its own.
    """
    canvas = image.copy() if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    height, width = canvas.shape[:2]
    scale = max(width / 480.0, 0.5)
    thick = max(round(scale), 1)
    colour = to_bgr(status_colour(estimate.status.value))
    if particles is not None:
        for x, y in particles[:, :2]:
            column, row = to_pixel(float(x), float(y), (width, height))
            cv2.circle(canvas, (round(column), round(row)), thick, to_bgr(PARTICLES), -1)
    claimed = estimate.status is TrackingStatus.TRACKING
    if claimed and len(estimate.outline):
        # The outline counts from the corner of the picture, OpenCV from the centre of a pixel.
        corners = np.floor(estimate.outline).astype(np.int32)
        cv2.polylines(canvas, [corners], True, to_bgr(AMBER), thick, cv2.LINE_AA)
    if claimed and estimate.box is not None:
        left, top, right, bottom = estimate.box
        last = (math.ceil(right) - 1, math.ceil(bottom) - 1)
        cv2.rectangle(canvas, (math.floor(left), math.floor(top)), last, colour, thick)
    _write_legend(canvas, estimate, scale, line)
    return canvas


def _write_legend(canvas: Image, estimate: TargetEstimate, scale: float, line: int) -> None:
    top, bottom = (round(LEGEND_HEIGHT * scale * number) for number in (line, line + 1))
    darken(canvas[top:bottom])
    status = estimate.status.value
    text = f"{status}  presence {estimate.presence:.2f}"
    if estimate.status is TrackingStatus.TRACKING:
        x, y = estimate.state[:2]
        text += f"  x {x:.0f}  y {y:.0f} px  scale {estimate.scale:.2f}"
    write_line(canvas, text, (round(6 * scale), bottom), 0.42 * scale, status_colour(status))
