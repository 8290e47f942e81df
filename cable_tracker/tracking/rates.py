"""What rates, and factors per frame, come to over a time; the probability of staying in view.

After J. Ha's thesis (2008, section 6.6): whether a target is in view is a Markov chain of two
states. Its probability of going out of view depends on the distance to the edge of the image; that
of coming into view has one rate for the whole image.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled_inside
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale

Number = TypeVar("Number", float, FloatArray)

SEARCH_SHARE = 1.0 / 3.0
"""Share of the births that are spread over the whole image right after the loss."""

LEAST_FADING = 1e-3
"""Lower bound of the factor by which the share of births about the last place falls with time."""

LARGEST_EXPONENT = 700.0
"""Bound of the argument of an exponential that does not overflow."""


@compiled_inside
def over_time(factor: float, dt: float) -> float:
    """Return the factor over `dt` seconds for a factor per frame of the reference rate, 25 Hz."""
    return float(factor ** (dt * REFERENCE_RATE))


def share_over_time(share: float, dt: float) -> float:
    """Return the share 1 - (1 - s)^n over the n frames of 25 Hz in `dt` seconds, s that of one.

    For one such frame it is s itself, bit for bit.
    """
    frames = dt * REFERENCE_RATE
    return share if frames == 1.0 else float(1.0 - (1.0 - share) ** frames)


def event_probability(rate: float, dt: float) -> float:
    """Return the probability of at least one event within `dt` seconds, for a rate [1/s]."""
    return -math.expm1(-rate * dt)


class SurvivalRates(NamedTuple):
    """Rates at which a target goes out of view.

    Attributes
    ----------
    vanishing : float
        In the middle of the image [1/s].
    leaving : float
        Added to the former at its edge [1/s].
    margin : float
        Scale of the logistic function of the distance to the edge [px].
    """

    vanishing: float
    leaving: float
    margin: float


def survival_rates(
    vanishing: float, leaving: float, margin: float, image_width: int
) -> SurvivalRates:
    """Return the rates for frames of a width [px]; `margin` [px at the reference width]."""
    return SurvivalRates(vanishing, leaving, margin * pixel_scale(image_width))


@compiled_inside
def survival_probability(inside: Number, rates: SurvivalRates, dt: float) -> Number:
    """Return the probability of being in view `dt` seconds later.

    `inside`: distance to the edge of the image [px], negative beyond it; any shape.
    """
    margins = np.minimum(np.maximum(inside / rates.margin, -LARGEST_EXPONENT), LARGEST_EXPONENT)
    at_edge = 1.0 / (1.0 + np.exp(margins))
    survival: Number = np.exp(-(rates.vanishing + rates.leaving * at_edge) * dt)
    return survival


def share_about_last_place(seconds: float, memory_time: float) -> float:
    """Return the share of the birth density about the place where the target was last seen.

    Parameters
    ----------
    seconds : float
        Time since it was last seen [s].
    memory_time : float
        Time constant of the share [s].
    """
    return (1.0 - SEARCH_SHARE) * max(math.exp(-seconds / memory_time), LEAST_FADING)
