"""Fast contours: Chan-Vese's energy lowered by switching single points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.contour.levels import Levels, levels_of_mask
from cable_tracker.contour.switching import FEWEST, SwitchingSettings, switch_points
from cable_tracker.errors import FrameError


@dataclass(frozen=True, slots=True)
class ContourSettings:
    """How contours evolve.

    Attributes
    ----------
    regulariser : float
        rho_1 of (17, 18): cost of a neighbour too many on the other side, in units of the data
        term. The thesis gives no value.
    balance : float
        eps_N: the regulariser acts only where the lengths of the two lists differ by more than this
        share; negative: always. The thesis gives no value; its figure 2 implies less than 0.027.
    iterations : int
        Largest number of iterations; hardly any contour needs as many as the default.
    flooding : bool
        Whether points that join a list are looked at in the same scan, so that one iteration can
        carry the contour any distance; otherwise by about a pixel.
    """

    regulariser: float = 0.0
    balance: float = 0.02
    iterations: int = 1000
    flooding: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """What a contour has become.

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


def evolve_by_means(
    image: NDArray[np.float32],
    start: BoolArray,
    settings: ContourSettings,
) -> Contour:
    """Separate two regions of different mean intensity: Table 1 of the thesis.

    Parameters
    ----------
    image : array
        Intensities in [0, 1], shape (H, W), float32.
    start : BoolArray
        Inside at the start, of the same shape.
    settings : ContourSettings
        Settings of the contour.

    Raises
    ------
    FrameError
        The shapes differ, or one of the regions has fewer than two points.
    """
    return _evolve(image, start, settings, by_means=True)


def evolve_by_ratio(
    log_ratio: NDArray[np.float32],
    start: BoolArray,
    settings: ContourSettings,
) -> Contour:
    """Separate what is likelier target from what is likelier background.

    Parameters
    ----------
    log_ratio : array
        log p(pixel | target) / p(pixel | background), plus the log-odds of a shape prior where
        there is one (`shape_prior.log_odds`); shape (H, W), float32.
    start, settings
        As for `evolve_by_means`.

    Raises
    ------
    FrameError
        As there.
    """
    return _evolve(log_ratio, start, settings, by_means=False)


def _evolve(
    data: NDArray[np.float32],
    start: BoolArray,
    settings: ContourSettings,
    *,
    by_means: bool,
) -> Contour:
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
    switching = SwitchingSettings(
        by_means, settings.regulariser, settings.balance, settings.flooding
    )
    iterations, inside, inside_sum, outside_sum = switch_points(
        pixels, levels, switching, settings.iterations
    )
    return Contour(
        levels=levels,
        iterations=iterations,
        inside_mean=inside_sum / inside,
        outside_mean=outside_sum / (levels.size - inside),
    )
