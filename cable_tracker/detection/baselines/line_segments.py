"""OpenCV's line segment detector, collinear segments joined, and parallel pairs.

References
----------
R. Grompone von Gioi, J. Jakubowicz, J.-M. Morel and G. Randall (2010), "LSD: A Fast Line Segment
Detector with a False Detection Control".

The first thing to try with OpenCV today. The constants were chosen on simulated dives of
the seeds 100 to 109.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.detection.baselines.segments import Segments, lines_of_segments
from cable_tracker.detection.border_lines import BorderLines, gradient_of
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, PairLimits
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import ResourceError
from cable_tracker.tracking.image_frame import pixel_to_image
from cable_tracker.tracking.parameter_table import pixel_scale

SIGMA = 1.0
"""Sigma of the smoothing before the gradient is read [px]."""

SCALE = 0.8
"""LSD reduces a picture to this share of its size before it looks at it."""

SHORTEST = 8.0
"""Shorter segments are left out [px at the reference width]."""

BRIGHT = 99.0
"""Percentile of the grey levels that becomes white."""

LARGEST_GAIN = 4.0

MINIMUM_CONTRAST = 1.5


class LineSegmentDetector(CableDetector):
    """Detect cables by OpenCV's LSD; see the module.

    Raises
    ------
    ResourceError
        This OpenCV has no line segment detector (4.1.0 to 4.5.0 have none).
    """

    minimum_score = 0.2

    def __init__(self, limits: PairLimits = DEFAULT_LIMITS) -> None:
        super().__init__(limits)
        self._finder = _make_finder()

    def _lines(self, pixels: Image, region: SearchRegion | None) -> BorderLines:
        segments = self._find_segments(pixels)
        segments = segments.selected(segments.lengths >= SHORTEST * pixel_scale(pixels.shape[1]))
        gradient = gradient_of(cv2.GaussianBlur(pixels, (0, 0), SIGMA))
        return lines_of_segments(segments.within(region), gradient, MINIMUM_CONTRAST)

    def _find_segments(self, pixels: Image) -> Segments:
        size = (pixels.shape[1], pixels.shape[0])
        found = self._finder.detect(_brightened(pixels))[0]
        ends: FloatArray = np.zeros((0, 4))
        if found is not None:
            ends = np.asarray(found, dtype=np.float64).reshape(-1, 4)
            # The centre of a pixel, c, comes to SCALE (c + 0.5) - 0.5 in the reduced picture. LSD
            # only divides what it finds there by SCALE, and so tells places too far to the left
            # and too high.
            ends += 0.5 / SCALE - 0.5
        return Segments(pixel_to_image(ends[:, :2], size), pixel_to_image(ends[:, 2:], size))


def _brightened(pixels: Image) -> Image:
    """Return uint8 grey levels that use their range: the detector's own threshold is a fixed one.

    Pictures of a bright scene stay as they are.
    """
    bright = max(float(np.percentile(pixels[::2, ::2], BRIGHT)), 1.0)
    gain = float(np.clip(255.0 / bright, 1.0, LARGEST_GAIN))
    return eight_bits(pixels * np.float32(gain))


def _make_finder() -> Any:  # noqa: ANN401
    try:
        return cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD, SCALE)
    except (AttributeError, cv2.error) as error:
        raise ResourceError(
            f"OpenCV {cv2.__version__} has no line segment detector; install 4.5.1 or newer"
        ) from error
