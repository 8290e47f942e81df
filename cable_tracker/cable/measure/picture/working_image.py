"""The picture in which borders are measured: grey, of a moderate width."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.map.cable_map import CableMap, cable_map_of
from cable_tracker.cable.measure.map.map_network import make_cable_map
from cable_tracker.cable.measure.picture.bend import (
    STRAIGHT,
    Bend,
    bend_after,
    bend_of_map,
    straightened,
)
from cable_tracker.cable.measure.picture.illumination import evenly_lit
from cable_tracker.cable.measure.picture.overlays import (
    StandingLines,
    standing_lines,
    without_dead_margins,
    without_standing_lines,
)
from cable_tracker.cable.measure.scan_filters import scan_kernels
from cable_tracker.cable.measure.scanned_gradients import ScanInputs, scan_frame
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.tracking.level_gain import amplified, level_gain
from cable_tracker.tracking.parameter_table import pixel_scale

SMALLEST_SIGMA = 0.5
"""Sigma that filters keep in narrow pictures [px]; below it, they fall between the pixels."""

REGION_SIGMA = 3.0
"""Sigma of the Gaussian that takes away the fine texture [px at the reference width]."""

CONTRAST_LAG = 12
"""Distance of the places whose difference is the contrast [px at the reference width]."""

THINNED_FROM, ROWS_PER_THINNED = 6, 3
"""Reduction from which on only every third row is averaged, and that three: to read all of a large
frame takes longer than the rest, and the mean is still over a dozen pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class PictureHistory:
    """State of the picture's preparation that is carried from frame to frame.

    Attributes
    ----------
    bend : Bend
        Bend that is taken out of the picture, for everything but the map.
    standing_lines : StandingLines or None
        For how long its pixels have been on thin lines; None for the first frame, or if lines are
        not taken out.
    gain : float
        Gain of the grey levels; kept while their spread changes little, see `level_gain`.
    """

    bend: Bend = STRAIGHT
    standing_lines: StandingLines | None = None
    gain: float = 1.0


NO_HISTORY = PictureHistory()
"""History before the first frame."""


@dataclass(frozen=True, eq=False)
class WorkingImage:
    """A frame prepared for measuring. Each product is computed when it is first read.

    Attributes
    ----------
    frame : Image
        Grey levels times the gain, uint8 or float32, shape (H, W); not copied where nothing had to
        be changed: valid as long as the frame.
    frame_size : (int, int)
        Width and height of the frame [px].
    size : (int, int)
        Width and height of the picture, at most those of the frame [px].
    frame_scale : float
        Pixels of the frame per pixel of an image of the reference width.
    reduction : float
        Working pixels per frame pixel, at most 1.
    scale : float
        Working pixels per pixel of an image of the reference width.
    line_spacing : int
        Distance between scan lines in the picture [px].
    parameters : TrackerParameters
        Parameters of preparation and measuring.
    gain : float
        Factor that the grey levels of the frame were multiplied by.
    history : PictureHistory
        History after the frame before.
    dt : float
        Time since the frame before [s].
    """

    frame: Image
    frame_size: tuple[int, int]
    size: tuple[int, int]
    frame_scale: float
    reduction: float
    scale: float
    line_spacing: int
    parameters: TrackerParameters
    gain: float
    history: PictureHistory
    dt: float

    @cached_property
    def pixels(self) -> Image:
        """Grey levels, float32, shape (h, w); those of a reduced uint8 frame are whole numbers."""
        return np.array(self._straight, dtype=np.float32, order="C")

    @cached_property
    def _straight(self) -> Image:
        """The cleared frame without its bend, of the frame's dtype."""
        cleared, _ = self._cleared
        bend = self.history.bend
        return cleared if bend == STRAIGHT else straightened(cleared, bend)

    @cached_property
    def _cleared(self) -> tuple[Image, StandingLines | None]:
        """The reduced frame without burned-in lines, of its dtype, and the times on thin lines."""
        reduced = self.frame
        if self.size != self.frame_size:
            height = len(reduced)
            if height >= THINNED_FROM * self.size[1] and height % ROWS_PER_THINNED == 0:
                # The middle one of every three rows: the centre of the picture stays where it is.
                reduced = reduced[ROWS_PER_THINNED // 2 :: ROWS_PER_THINNED]
            reduced = np.asarray(cv2.resize(reduced, self.size, interpolation=cv2.INTER_AREA))
        if self.parameters.burned_in_time == 0.0:
            return reduced, None
        lines = standing_lines(self.history.standing_lines, reduced, self.dt, self.scale)
        if lines is None:
            return reduced, None
        return without_standing_lines(reduced, lines, self.parameters.burned_in_time), lines

    @cached_property
    def cable_map(self) -> CableMap:
        """Probabilities that cells are cable, in the straightened picture."""
        bent = self._bent_map
        if self.history.bend == STRAIGHT:
            return bent
        probabilities = straightened(bent.probabilities, self.history.bend)
        return cable_map_of(probabilities, bent.left, bent.top, bent.cell)

    @cached_property
    def _bent_map(self) -> CableMap:
        cleared, _ = self._cleared
        return make_cable_map(cleared.astype(np.float32), self.frame_size[0])

    @property
    def next_history(self) -> PictureHistory:
        """The history for the next frame.

        While there is a bend, the map is computed in every frame: it tells when the bend has ended.
        Without one, a bend is looked for only in frames whose map was computed anyway.
        """
        bend = self.history.bend
        # A cached property that was read stands among the variables of its object.
        has_map = "_bent_map" in vars(self)
        if has_map or bend != STRAIGHT:
            bend = bend_after(bend, bend_of_map(self._bent_map.probabilities))
        _, lines = self._cleared
        return PictureHistory(bend, lines, self.gain)

    @cached_property
    def scan(self) -> ScanInputs:
        """Gradients and grey levels along the scan lines."""
        kernels = scan_kernels(
            max(self.parameters.filter_sigma * self.scale, SMALLEST_SIGMA),
            REGION_SIGMA * self.scale,
            max(1, round(CONTRAST_LAG * self.scale)),
        )
        if self.parameters.observation == "responses":
            # The observation of the thesis measures gradients alone.
            kernels = kernels._replace(region=kernels.region[:0])
        picture = evenly_lit(self._straight, self.parameters.light_correction)
        return scan_frame(picture, self.line_spacing, kernels, self.reduction, self.scale)


@cache
def _working_size(
    frame_size: tuple[int, int], working_width: int
) -> tuple[tuple[int, int], float, float, float]:
    """Return `size`, `frame_scale`, `reduction` and `scale` of all `WorkingImage` of a size."""
    width, height = size = frame_size
    if width > working_width:
        size = (working_width, max(1, round(height * working_width / width)))
    return size, pixel_scale(width), size[0] / width, pixel_scale(size[0])


def working_image_for(
    image: Image,
    parameters: TrackerParameters,
    history: PictureHistory = NO_HISTORY,
    dt: float = 0.0,
) -> WorkingImage:
    """Fill dead margins, and reduce a wider frame to the working width by averaging over areas.

    The levels of a deep picture that uses few of them are amplified; see `level_gain`.

    Parameters
    ----------
    image : Image
        Grey levels, uint8 or float32, shape (H, W).
    parameters : TrackerParameters
        The tracker's parameters.
    history, dt : PictureHistory, float
        History after the frame before, and the time since [s].
    """
    if history.bend != STRAIGHT and not parameters.uses_map:
        # Without maps, nothing would tell that a bend has ended.
        history = replace(history, bend=STRAIGHT)
    gain = level_gain(history.gain, image)
    image = without_dead_margins(amplified(image, gain))
    height, width = image.shape
    size, frame_scale, reduction, scale = _working_size((width, height), parameters.working_width)
    return WorkingImage(
        image,
        (width, height),
        size,
        frame_scale,
        reduction,
        scale,
        max(1, round(parameters.sample_spacing * scale)),
        parameters,
        gain,
        history,
        dt,
    )
