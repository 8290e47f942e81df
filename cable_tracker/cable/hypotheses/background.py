"""How well the bottom fits a hypothesis' borders without a cable: its background.

Ripples, tracks and the grain of gravel run in one direction and have one width. So a hypothesis is
held against strips that run as it does, are about as wide, and lie elsewhere in the same frame: as
much as the best of them is worth, the bottom explains. On coarse gravel any strip fits well
somewhere; so it is held against strips of any kind, too: it stands above their mean by some of
their standard deviations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.frame_inputs import FrameConfig, FrameInputs, FrameNoise
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    marginal_log_ratios,
    measured_cables,
)
from cable_tracker.cable.model.geometry import (
    borders_cross_inside,
    image_reach,
    relative_direction,
)
from cable_tracker.cable.model.initial_state import between
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled_loop, compiled_part

ALIKE_ANGLE, ALIKE_LOG_WIDTH, ALIKE_SKEW = math.radians(3.0), 0.25, math.radians(1.5)
"""Standard deviations of alpha [rad], log w and beta [rad] of strips like a hypothesis about it."""

BEST_OF_ANY = 3.0
"""Height of the best strips of any kind above their mean, in standard deviations."""

SMALLEST_DEVIATION = 0.5
"""Lower bound of the standard deviation of the strips of any kind [nats]."""

FEWEST_STRIPS = 8
"""Minimum number of random strips for their mean and deviation; with fewer 0 and
`SMALLEST_DEVIATION` are used."""

SHARED_OFFSET, SHARED_ANGLE = 8.0, 0.12
"""Largest distance and angle between two borders that may be the same one [px at the reference
width, rad]."""


class Background(NamedTuple):
    """What K hypotheses or groups are held against, log-likelihood ratios, shape (K,) [nats].

    Attributes
    ----------
    alike : FloatArray
        Log-likelihood ratio of the best strip like the hypothesis, at least 0.
    means, deviations : FloatArray
        Mean and standard deviation of the log-likelihood ratios of strips of any kind.
    """

    alike: FloatArray
    means: FloatArray
    deviations: FloatArray


@compiled_part
def background_of(states: FloatArray, inputs: FrameInputs, config: FrameConfig) -> Background:
    """Measure strips beside each of K hypotheses or groups, shape (K, 8), in the inputs' frame.

    The strips that are like hypotheses are shared out among them.
    """
    noise, count = inputs.noise, len(states)
    background = Background(np.zeros(count), np.zeros(count), np.full(count, SMALLEST_DEVIATION))
    if count == 0:
        return background
    share = len(noise.alike) // count
    strips = np.zeros((len(noise.anywhere) + count * share, STATE_SIZE))
    # A strip that no hypothesis is held against is not kept: the next one takes its row.
    kinds = 0
    for row in range(len(noise.anywhere)):
        _place_anywhere(noise.anywhere[row], config, strips[kinds])
        kinds += _is_of_use_for_any(strips[kinds], states, config)
    total, ends = kinds, np.empty(count, np.int64)
    for row in range(count * share):
        index = row // share
        _place_like(states[index], noise, row, config, strips[total])
        total += _is_beside(strips[total], states[index], config)
        ends[index] = total
    measured = measured_cables(strips[:total], inputs.scan, inputs.model)
    ratios = marginal_log_ratios(measured.log_ratios, inputs.polarity)
    first = kinds
    for index in range(count):
        background.means[index], background.deviations[index] = _moments(
            strips, ratios, kinds, states[index], config.frame_scale
        )
        for row in range(first, ends[index]):
            background.alike[index] = max(background.alike[index], ratios[row])
        first = ends[index]
    return background


@compiled_loop
def _is_of_use_for_any(strip: FloatArray, means: FloatArray, config: FrameConfig) -> bool:
    """Tell whether a strip may be a cable, and at least one hypothesis shares no border with it."""
    apart = False
    for index in range(len(means)):
        apart = apart or not shares_border(strip, means[index], config.frame_scale)
    return apart and not borders_cross_inside(strip, config.image_size)


@compiled_loop
def _is_beside(strip: FloatArray, mean: FloatArray, config: FrameConfig) -> bool:
    """Tell whether a strip may be a cable, and does not lie on a hypothesis."""
    return (
        abs(strip[DISTANCE] - mean[DISTANCE]) >= 0.5 * mean[WIDTH]
        and not borders_cross_inside(strip, config.image_size)
        and not shares_border(strip, mean, config.frame_scale)
    )


@compiled_loop
def shares_border(strip: FloatArray, mean: FloatArray, scale: float) -> bool:
    """Tell whether any border of a strip (8,) may be the same as any of a hypothesis (8,).

    Distances are between the crossings d -+ w/2 with the centrelines' normals. `scale`: pixels of
    the frame per pixel at the reference width.
    """
    wrapped, sign = relative_direction(strip[ANGLE], mean[ANGLE])
    offset, angle, skew = sign * strip[DISTANCE], wrapped + mean[ANGLE], sign * strip[SKEW]
    nearest = SHARED_OFFSET * scale
    for side in (-1.0, 1.0):
        for other in (-1.0, 1.0):
            own, its = offset + 0.5 * side * strip[WIDTH], 0.5 * other * mean[WIDTH]
            apart = own - mean[DISTANCE] - its
            turn = angle + side * skew - mean[ANGLE] - other * mean[SKEW]
            if abs(apart) < nearest and abs(turn) < SHARED_ANGLE:
                return True
    return False


@compiled_loop
def _moments(
    strips: FloatArray, ratios: FloatArray, count: int, mean: FloatArray, scale: float
) -> tuple[float, float]:
    """Return mean and standard deviation over the first strips that share no border with one."""
    used, total, squares = 0, 0.0, 0.0
    for row in range(count):
        if not shares_border(strips[row], mean, scale):
            used, total, squares = used + 1, total + ratios[row], squares + ratios[row] ** 2
    if used < FEWEST_STRIPS:
        return 0.0, SMALLEST_DEVIATION
    average = total / used
    deviation = math.sqrt(max(squares / used - average * average, 0.0))
    return average, max(deviation, SMALLEST_DEVIATION)


@compiled_loop
def _place_anywhere(uniform: FloatArray, config: FrameConfig, strip: FloatArray) -> None:
    """Draw a strip of any kind that crosses the frame."""
    limits = config.limits
    strip[ANGLE] = (uniform[ANGLE] - 0.5) * math.pi
    strip[WIDTH] = between(limits.lower[WIDTH], limits.upper[WIDTH], uniform[WIDTH])
    strip[SKEW] = between(limits.lower[SKEW], limits.upper[SKEW], uniform[SKEW])
    reach = image_reach(strip[ANGLE], config.image_size[0], config.image_size[1])
    strip[DISTANCE] = (2.0 * uniform[DISTANCE] - 1.0) * reach


@compiled_loop
def _place_like(
    mean: FloatArray,
    noise: FrameNoise,
    row: int,
    config: FrameConfig,
    strip: FloatArray,
) -> None:
    """Draw a strip that runs as a hypothesis does, anywhere in the frame."""
    (lower, upper), deviates = config.limits, noise.alike[row]
    strip[ANGLE] = mean[ANGLE] + ALIKE_ANGLE * deviates[0]
    width = mean[WIDTH] * math.exp(ALIKE_LOG_WIDTH * deviates[1])
    strip[WIDTH] = min(max(width, lower[WIDTH]), upper[WIDTH])
    skew = mean[SKEW] + ALIKE_SKEW * deviates[2]
    strip[SKEW] = min(max(skew, lower[SKEW]), upper[SKEW])
    reach = image_reach(strip[ANGLE], config.image_size[0], config.image_size[1])
    strip[DISTANCE] = (2.0 * noise.elsewhere[row] - 1.0) * reach
