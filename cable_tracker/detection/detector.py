"""What every whole-image cable detector looks like."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.picture.working_image import working_image_for
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.pair_limits import DEFAULT_LIMITS, PairLimits
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.frame_check import check_frame
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

PLAIN = TrackerParameters(
    working_width=round(REFERENCE_WIDTH), light_correction=0.0, burned_in_time=0.0
)
"""How the tracker makes a picture ready of which nothing is taken out."""


@dataclass(frozen=True, slots=True)
class Detection:
    """One cable that a detector believes to see.

    Attributes
    ----------
    state : CableState
        State of the cable [px, rad]; a single picture tells no rates, they are 0.
    score : float
        Clearness of the cable, from 0 to 1. Comparable within one detector only.
    """

    state: CableState
    score: float


class CableDetector(ABC):
    """Finds cables in one picture, without a memory.

    Pictures wider than the reference width are reduced as the tracker reduces them, so that all
    methods see the same.

    Parameters
    ----------
    limits : PairLimits
        Widths and skews of the cables that are reported.
    """

    def __init__(self, limits: PairLimits = DEFAULT_LIMITS) -> None:
        self._limits = limits

    def detect(self, image: Image, region: SearchRegion | None = None) -> list[Detection]:
        """Return the cables in a picture, best first; an empty list if there are none.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        region : SearchRegion or None
            Look here only, in the frame of `image`; everywhere if None.

        Raises
        ------
        FrameError
            The picture cannot be used.
        """
        check_frame(image)
        working = working_image_for(image, PLAIN)
        reduction = working.reduction
        reduced = region.scaled(reduction) if region is not None else None
        return [
            Detection(found.state.scaled(1.0 / reduction), found.score)
            for found in self._detect(working.pixels, reduced)
        ]

    @abstractmethod
    def _detect(self, pixels: Image, region: SearchRegion | None) -> list[Detection]:
        """Return the cables in float32 grey levels of shape (h, w), best first."""
