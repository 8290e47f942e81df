"""Fast contours: Chan-Vese's energy lowered by switching single points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.contour.switching import (
    FEWEST,
    ContourSettings,
    Levels,
    levels_of_mask,
    switch_points,
)
from cable_tracker.errors import FrameError


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Result of an evolution.

    Attributes
    ----------
    levels : Levels
        Level set, shape of the picture.
    iterations : int
        Number of iterations that were done.
    inside_mean, outside_mean : float
        Mean of the data on either side.
    """

    levels: Levels
    iterations: int
    inside_mean: float
    outside_mean: float

    @property
    def mask(self) -> BoolArray:
        """The inside, shape of the picture."""
        inside: BoolArray = self.levels < 0
        return inside

    @property
    def contrast(self) -> float:
        """Difference of the two means, positive."""
        return abs(self.inside_mean - self.outside_mean)


def evolve(
    data: NDArray[np.float32], start: BoolArray, settings: ContourSettings, *, by_means: bool
) -> Contour:
    """Evolve a contour: Table 1 of the thesis.

    Parameters
    ----------
    data : array
        Intensities in [0, 1], or log p(pixel | target) / p(pixel | background), plus the log-odds
        of a shape prior where there is one (`shape_prior.log_odds`); shape (H, W), float32.
    start : BoolArray
        Inside at the start, of the same shape.
    settings : ContourSettings
        Settings of the contour.
    by_means : bool
        Whether `data` are intensities, separated by their means, or log-likelihood ratios,
        separated by their sign.

    Raises
    ------
    FrameError
        The shapes differ, or one of the regions has fewer than two points.
    """
    if data.ndim != 2 or data.shape != start.shape:
        raise FrameError(f"a contour of shape {start.shape} cannot evolve on data {data.shape}")
    levels = levels_of_mask(start)
    inside = int(np.count_nonzero(levels < 0))
    if min(inside, levels.size - inside) < FEWEST:
        raise FrameError(
            f"a contour needs {FEWEST} points on either side,"
            f" not {inside} and {levels.size - inside}"
        )
    pixels = np.ascontiguousarray(data, dtype=np.float32)
    iterations, inside, inside_sum, outside_sum = switch_points(pixels, levels, settings, by_means)
    return Contour(
        levels=levels,
        iterations=iterations,
        inside_mean=inside_sum / inside,
        outside_mean=outside_sum / (levels.size - inside),
    )
