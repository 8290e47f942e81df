"""How well the bottom fits a hypothesis' borders without a cable: its background.

Ripples, tracks and the grain of gravel run in one direction and have one width. So a hypothesis is
held against strips that run as it does, are about as wide, and lie elsewhere in the same frame: as
much as the best of them is worth, the bottom explains. On coarse gravel any strip fits well
somewhere; so it is held against strips of any kind, too: it stands above their mean by some of
their spreads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise
from cable_tracker.cable.measure.border_points import FrameScan
from cable_tracker.cable.measure.likelihood_ratio import (
    CableEvidence,
    RatioModel,
    marginal_log_ratio,
    measure_into,
)
from cable_tracker.cable.model.geometry import borders_cross_inside, reach_at, unwrap_state
from cable_tracker.cable.model.state import STATE_SIZE
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.compilation import compiled_part

SPREADS = np.array([math.radians(3.0), 0.25, math.radians(1.5)])
"""How like a hypothesis strips are: spread of alpha [rad], log w and beta [rad]."""

APART, TURNED = 8.0, 0.12
"""A strip shares a border with a hypothesis if they are nearer than this [px at the reference
width, rad]."""

SPREADS_ABOVE = 3.0
"""The best of the strips of any kind stand so many of their spreads above their mean."""

SMALLEST_SPREAD = 0.5
"""Smallest spread of the strips of any kind [nats]."""

FEWEST = 8
"""Fewer strips of any kind say nothing."""


class Background(NamedTuple):
    """What K hypotheses are held against, log-likelihood ratios, each of shape (K,) [nats].

    Attributes
    ----------
    alike : FloatArray
        Of the best strip that is like the hypothesis, at least 0.
    means, spreads : FloatArray
        Mean and standard deviation over strips of any kind.
    """

    alike: FloatArray
    means: FloatArray
    spreads: FloatArray


@compiled_part
def background_of(
    means: FloatArray,
    noise: FrameNoise,
    scan: FrameScan,
    model: RatioModel,
    p_bright: float,
    lower: FloatArray,
    upper: FloatArray,
    image_size: tuple[float, float],
) -> Background:
    """Measure strips beside each of K hypotheses.

    Parameters
    ----------
    means : FloatArray
        The hypotheses, shape (K, 8).
    noise : FrameNoise
        Of the frame; the strips like them are shared out among them.
    scan, model : FrameScan, RatioModel
        Of the frame.
    p_bright : float
        Probability that a cable is bright.
    lower, upper : FloatArray
        Limits of a pose, shape (4,) [px, rad].
    image_size : (float, float)
        Width and height of the frame [px].
    """
    count, kinds = len(means), len(noise.anywhere)
    background = Background(np.zeros(count), np.zeros(count), np.full(count, SMALLEST_SPREAD))
    if count == 0:
        return background
    share = len(noise.alike) // count
    total = kinds + count * share
    strips = np.zeros((total, STATE_SIZE))
    for row in range(kinds):
        _place_anywhere(noise.anywhere[row], lower, upper, image_size, strips[row])
    for row in range(kinds, total):
        mean = means[(row - kinds) // share]
        _place_like(mean, noise, row - kinds, lower, upper, image_size, strips[row])
    evidence = CableEvidence(np.empty((total, 2)), np.empty((total, 2)), np.empty(total))
    measure_into(strips, 0, total, scan, model, evidence)
    log_bright, log_dark = math.log(p_bright), math.log1p(-p_bright)
    ratios = np.empty(total)
    for row in range(total):
        ratios[row] = marginal_log_ratio(
            log_bright + evidence.log_ratios[row, 0], log_dark + evidence.log_ratios[row, 1]
        )
        if borders_cross_inside(strips[row], image_size):
            ratios[row] = -np.inf
    for index in range(count):
        first = kinds + index * share
        background.means[index], background.spreads[index] = _moments(
            strips[:kinds], ratios[:kinds], means[index], image_size[0]
        )
        background.alike[index] = _best(
            strips[first : first + share],
            ratios[first : first + share],
            means[index],
            image_size[0],
        )
    return background


@compiled_part
def _moments(
    strips: FloatArray, ratios: FloatArray, mean: FloatArray, image_width: float
) -> tuple[float, float]:
    """Return mean and spread over strips of any kind that share no border with a hypothesis."""
    used, total, squares = 0, 0.0, 0.0
    for row in range(len(strips)):
        if ratios[row] > -np.inf and not _shares_border(strips[row], mean, image_width):
            used, total, squares = used + 1, total + ratios[row], squares + ratios[row] ** 2
    if used < FEWEST:
        return 0.0, SMALLEST_SPREAD
    average = total / used
    spread = math.sqrt(max(squares / used - average * average, 0.0))
    return average, max(spread, SMALLEST_SPREAD)


@compiled_part
def _best(strips: FloatArray, ratios: FloatArray, mean: FloatArray, image_width: float) -> float:
    """Return the largest ratio of strips that do not lie on a hypothesis; 0 without any."""
    best = 0.0
    for row in range(len(strips)):
        beside = abs(strips[row, 0] - mean[0]) >= 0.5 * mean[2]
        if beside and not _shares_border(strips[row], mean, image_width):
            best = max(best, ratios[row])
    return best


@compiled_part
def _place_anywhere(
    uniform: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    image_size: tuple[float, float],
    strip: FloatArray,
) -> None:
    """Draw a strip of any kind that crosses the frame."""
    strip[1] = (uniform[1] - 0.5) * math.pi
    strip[2] = lower[2] + uniform[2] * (upper[2] - lower[2])
    strip[3] = lower[3] + uniform[3] * (upper[3] - lower[3])
    reach = reach_at(strip[1], image_size[0], image_size[1])
    strip[0] = (2.0 * uniform[0] - 1.0) * reach


@compiled_part
def _place_like(
    mean: FloatArray,
    noise: FrameNoise,
    row: int,
    lower: FloatArray,
    upper: FloatArray,
    image_size: tuple[float, float],
    strip: FloatArray,
) -> None:
    """Draw a strip that runs as a hypothesis does, anywhere in the frame."""
    strip[1] = mean[1] + SPREADS[0] * noise.alike[row, 0]
    width = mean[2] * math.exp(SPREADS[1] * noise.alike[row, 1])
    strip[2] = min(max(width, lower[2]), upper[2])
    strip[3] = min(max(mean[3] + SPREADS[2] * noise.alike[row, 2], lower[3]), upper[3])
    reach = reach_at(strip[1], image_size[0], image_size[1])
    strip[0] = (2.0 * noise.elsewhere[row] - 1.0) * reach


@compiled_part
def _shares_border(strip: FloatArray, mean: FloatArray, image_width: float) -> bool:
    """Tell whether a border of a strip lies on one of a hypothesis."""
    chart = np.empty(STATE_SIZE)
    unwrap_state(strip, mean[1], chart)
    distance = APART * image_width / REFERENCE_WIDTH
    for side in (-1.0, 1.0):
        for other in (-1.0, 1.0):
            apart = chart[0] + 0.5 * side * chart[2] - mean[0] - 0.5 * other * mean[2]
            turn = chart[1] + side * chart[3] - mean[1] - other * mean[3]
            if abs(apart) < distance and abs(turn) < TURNED:
                return True
    return False
