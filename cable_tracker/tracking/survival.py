"""Whether what is tracked is still in view: it vanishes anywhere, and leaves over the edge.

After J. Ha's thesis (2008, section 6.6): whether a target is in view is a Markov chain of two
states, whose transition probabilities depend on the distance to the border of the image. The other
direction, how likely it comes into view, has a rate of its own; where it does so depends on the
target: about where it was last seen, the less so the longer that is ago.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled_inside
from cable_tracker.tracking.parameter_table import pixel_scale

Number = TypeVar("Number", float, FloatArray)

SEARCH_SHARE = 1.0 / 3.0
"""Share of the births without knowledge of the last place right after the loss."""

LEAST_FADING = 1e-3
"""Births about the last place never quite end: that costs the search without knowledge nothing."""

LARGEST_EXPONENT = 700.0
"""Larger ones overflow."""


class SurvivalRates(NamedTuple):
    """How often what is in view goes out of it.

    Attributes
    ----------
    vanishing : float
        In the middle of the image [1/s].
    leaving : float
        At its edge, added to the former [1/s].
    margin : float
        Distance to the edge at which leaving begins [px].
    """

    vanishing: float
    leaving: float
    margin: float


def survival_rates(
    vanishing: float, leaving: float, margin: float, image_width: int
) -> SurvivalRates:
    """Return the rates for frames of a width [px], of a margin [px at the reference width]."""
    return SurvivalRates(vanishing, leaving, margin * pixel_scale(image_width))


@compiled_inside
def survival_probability(inside: Number, rates: SurvivalRates, dt: float) -> Number:
    """Return the probabilities of still being in view `dt` seconds later.

    `inside` are the distances to the edge of the image [px], negative beyond it; any shape.
    """
    margins = np.minimum(np.maximum(inside / rates.margin, -LARGEST_EXPONENT), LARGEST_EXPONENT)
    at_edge = 1.0 / (1.0 + np.exp(margins))
    survival: Number = np.exp(-(rates.vanishing + rates.leaving * at_edge) * dt)
    return survival


def share_about_last_place(seconds: float, memory_time: float) -> float:
    """Return the share of the births about the place where the target was last seen.

    Parameters
    ----------
    seconds : float
        Time since it was last seen [s].
    memory_time : float
        Time constant of the share [s].
    """
    return (1.0 - SEARCH_SHARE) * max(math.exp(-seconds / memory_time), LEAST_FADING)
