"""Base class of whole-image cable detectors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.picture.working_image import working_image_for
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.border_lines import BorderLines
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, Detection, PairLimits, pair_lines
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH
from cable_tracker.tracking.succession import check_frame

PLAIN = TrackerParameters(
    working_width=round(REFERENCE_WIDTH), light_correction=0.0, burned_in_time=0.0
)
"""Parameters of a working image without corrections."""


class CableDetector(ABC):
    """Finds cables in single pictures, between pairs of lines.

    Pictures wider than the reference width are reduced as the tracker reduces them, so that all
    methods get the same.

    Parameters
    ----------
    limits : PairLimits
        Widths and skews of the cables that are reported.
    """

    minimum_score: ClassVar[float]
    """Weaker cables are not reported, see `pair_lines`."""

    def __init__(self, limits: PairLimits = DEFAULT_LIMITS) -> None:
        self._limits = limits

    def detect(self, image: Image, region: SearchRegion | None = None) -> list[Detection]:
        """Return the cables in a picture, best first; an empty list if there are none.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        region : SearchRegion or None
            Region to search, in the frame of `image`; None: everywhere.

        Raises
        ------
        FrameError
            The picture cannot be used.
        """
        check_frame(image)
        working = working_image_for(image, PLAIN)
        reduction = working.reduction
        reduced = region.scaled(reduction) if region is not None else None
        lines = self._lines(working.pixels, reduced)
        found = pair_lines(lines, working.size, reduced, self.minimum_score, self._limits)
        return [Detection(each.state.scaled(1.0 / reduction), each.score) for each in found]

    @abstractmethod
    def _lines(self, pixels: Image, region: SearchRegion | None) -> BorderLines:
        """Return lines that may be borders in float32 grey levels of shape (h, w)."""
