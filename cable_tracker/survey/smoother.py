"""Smoothing of a dive's claims: a cable lies still, so that later claims inform earlier places.

Where the camera looks, the cable has a place beside the look line, a direction and a curvature.
From one keyframe to the next the vehicle moves as odometry has it, and the cable goes on as a curve
whose curvature forgets itself over some metres. Each tracked frame measures place and direction.
Their errors are far from independent: consecutive pictures show nearly the same piece of cable,
with the same growth on it. They count together as about one measurement for each `CORRELATION` of
way.

Forwards this is a Kalman filter, backwards the smoother of Rauch, Tung and Striebel. Claims that do
not fit to what lies before and behind lose their weight, as with Student's t.

Gaussians instead of smoothed particles: by the time that a cable is claimed the tracker has settled
on one place, what is smoothed lies in a plane in metres, and stretches of a hundred metres without
a claim are bridged with a covariance, where particles would have died out.

References
----------
H. E. Rauch, F. Tung and C. T. Striebel (1965), "Maximum likelihood estimates of linear dynamic
systems".
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.survey.curve_filter import (
    SmoothedCable,
    filter_forwards,
    smooth_backwards,
)
from cable_tracker.survey.keyframes import LEAST_SPACING, Keyframes, step_lengths, summed
from cable_tracker.survey.memory_mapped import Disk

CORRELATION = 0.7
"""Distance over which the errors of claims are correlated [m]."""

UNSURE = 1.5
"""Standard deviation of the place of an unsure claim, as a multiple of the dive's usual one. Where
sand begins to cover a cable, claims in a row are off by alike, so that they fit to each other: by
how much is what the tracker said, not what the clear claims show."""

BEND = 0.05
"""Initial standard deviation of the curvature [1/m]."""

LEAST_BEND, MOST_BEND = 0.01, 0.2
"""Limits of the standard deviation of the curvature that the smoothed claims give [1/m]."""

YAW_SIGMA = math.radians(0.2)
"""Standard deviation of each yaw of odometry [rad]."""

FLOOR = 0.004
"""Standard deviation added to the place of each claim, as its smallest error [m]."""

HEADING_FLOOR = math.radians(0.5)
"""Standard deviation added to the direction of each claim, for a straight line in a picture of a
bent cable [rad]."""

DEGREES = 4.0
"""Degrees of freedom of Student's t."""

MEDIAN_SQUARE = 0.455
"""Median of the square of a standard normal variable."""

ROUNDS = 4

LEAST_SCALE, MOST_SCALE = 0.3, 8.0
"""Limits of the factor by which the tracker's standard deviations are corrected."""

FITTING, SURE_ENOUGH = 3.0, 0.25
"""Largest residual of a doubtful claim that counts [standard deviations], and largest standard
deviation of the place from the other claims for that [m]."""


def smooth(keyframes: Keyframes, disk: Disk, *, backward_pass: bool = True) -> SmoothedCable:
    """Smooth the claims of a dive in both directions, or only filter them forwards.

    The arrays of the result are allocated by `disk`.
    """
    count = len(keyframes.stamps)
    cable = SmoothedCable(
        disk.array(count),
        disk.array((count, 3)),
        disk.array((count, 3, 3)),
        # What may be something else has to fit to what the others say, so these come first.
        disk.filled(count, lambda part: np.where(_usual_claims(keyframes, part), 1.0, 0.0)),
        disk.array(count, np.int64),
        (1.0, 1.0),
        BEND,
    )
    steps = disk.filled(count, lambda part: step_lengths(keyframes.look_lines, part))
    inflation = _covariance_inflation(summed(steps, disk), keyframes.claims, disk)
    usual = _usual_variance(keyframes, disk)
    for _ in range(ROUNDS):
        for part in disk.blocks(count):
            noise = _noise(keyframes.covariances[part], cable.scales, usual)
            noise *= inflation[part, None]
            filter_forwards(keyframes, noise, part.start, cable)
        for part in disk.blocks_reversed(count) if backward_pass else ():
            smooth_backwards(keyframes, part.start, part.stop, cable)
        cable = _with_new_weights(keyframes, cable, usual, disk)
    return cable


def _usual_claims(keyframes: Keyframes, part: slice) -> BoolArray:
    """Tell for some keyframes whether they have a claim that is surely of the cable."""
    claimed: BoolArray = np.isfinite(keyframes.claims[part].sum(axis=1))
    return claimed & ~keyframes.doubtful[part]


def _usual_variance(keyframes: Keyframes, disk: Disk) -> float:
    """Return the median variance of the place of claims that are surely of the cable [m²]; or NaN.

    It is as the tracker states it.
    """
    count = len(keyframes.stamps)
    if not any(_usual_claims(keyframes, part).any() for part in disk.blocks(count)):
        return math.nan
    variances = keyframes.covariances[:, 0]
    return disk.median(variances, lambda part: _usual_claims(keyframes, part))


def _with_new_weights(
    keyframes: Keyframes, cable: SmoothedCable, usual: float, disk: Disk
) -> SmoothedCable:
    """Return a smoothed cable with scales and bend as its claims have them, and new weights.

    `usual` is the usual variance of the place of a claim [m²]; NaN where no claim is surely of the
    cable.
    """
    count, scales, bend = len(keyframes.stamps), cable.scales, cable.bend
    squares = disk.filled(count, lambda part: _normalised_squares(keyframes, cable, usual, part))
    misses = np.ones(2)
    if not math.isnan(usual):
        medians = [
            disk.median(column, lambda part: _usual_claims(keyframes, part)) for column in squares.T
        ]
        misses = np.sqrt(np.array(medians) / MEDIAN_SQUARE)
        place, direction = np.clip(np.array(scales) * misses, LEAST_SCALE, MOST_SCALE).tolist()
        scales, bend = (place, direction), _bend(cable, disk)
        misses = np.maximum(misses, 1e-9)
    for part in disk.blocks(count):
        residuals = keyframes.claims[part] - cable.states[part, :2]
        plain = _noise(keyframes.covariances[part], cable.scales, usual)
        claimed: BoolArray = np.isfinite(keyframes.claims[part].sum(axis=1))
        fits = _fits(residuals, plain, cable.covariances[part])
        counts = _usual_claims(keyframes, part) | (claimed & fits)
        far = (squares[part] / misses**2).sum(axis=1)
        cable.weights[part] = np.where(counts, (DEGREES + 2.0) / (DEGREES + far), 0.0)
    return cable._replace(scales=scales, bend=bend)


def _normalised_squares(
    keyframes: Keyframes, cable: SmoothedCable, usual: float, part: slice
) -> FloatArray:
    """Return squared residuals of some claims over the variances of the claims, shape (K, 2)."""
    residuals = keyframes.claims[part] - cable.states[part, :2]
    noise = _noise(keyframes.covariances[part], cable.scales, usual)
    squares: FloatArray = residuals**2 / noise[:, ::2]
    return squares


def _covariance_inflation(travelled: FloatArray, claims: FloatArray, disk: Disk) -> FloatArray:
    """Return by how much each claim's covariance is multiplied, shape (S,), at least 1.

    It is because errors of neighbouring claims are correlated over `CORRELATION` metres.

    Parameters
    ----------
    travelled : FloatArray
        Distance travelled by the look line since the first keyframe, shape (S,) [m].
    claims : FloatArray
        Claims of the keyframes, shape (S, 2); NaN where a keyframe has none.
    disk : Disk
        Allocator of the arrays.
    """
    count = len(travelled)
    inflation: FloatArray = disk.filled(count, lambda part: np.ones(part.stop - part.start))
    where = disk.growing(np.int64)
    for part in disk.blocks(count):
        where.extend(np.flatnonzero(np.isfinite(claims[part].sum(axis=1))) + part.start)
    claimed = where.rows()
    last = len(claimed) - 1

    def distance_to_next(numbers: IndexArray) -> FloatArray:
        distances: FloatArray = travelled[claimed[numbers + 1]] - travelled[claimed[numbers]]
        return distances

    for part in disk.blocks(len(claimed)) if last > 0 else ():
        number = np.arange(part.start, part.stop)
        # The first and the last have a neighbour on one side only, which stands for both.
        before = distance_to_next(np.maximum(number - 1, 0))
        after = distance_to_next(np.minimum(number, last - 1))
        # Beside a silence the claims on the other side tell how dense they are.
        before, after = (
            np.where(before > CORRELATION, after, before),
            np.where(after > CORRELATION, before, after),
        )
        inflation[claimed[part]] = CORRELATION / np.clip(
            (before + after) / 2, LEAST_SPACING, CORRELATION
        )
    return inflation


def _bend(cable: SmoothedCable, disk: Disk) -> float:
    """Return the curvature's standard deviation, as expectation and maximisation has it [1/m]."""
    squares = disk.filled(
        len(cable.along),
        lambda part: cable.states[part, 2] ** 2 + cable.covariances[part, 2, 2],
    )
    square = float(np.mean(squares))
    return min(max(math.sqrt(square), LEAST_BEND), MOST_BEND)


def _fits(residuals: FloatArray, noise: FloatArray, covariances: FloatArray) -> BoolArray:
    """Tell which claims lie where the cable is known to be, shape (S,)."""
    known = covariances[:, 0, 0] < SURE_ENOUGH**2
    near = residuals[:, 0] ** 2 < FITTING**2 * (noise[:, 0] + covariances[:, 0, 0])
    along = residuals[:, 1] ** 2 < FITTING**2 * (noise[:, 2] + covariances[:, 1, 1])
    fits: BoolArray = known & near & along
    return fits


def _noise(covariances: FloatArray, scales: tuple[float, float], usual: float) -> FloatArray:
    """Return the noise of claims: variance of place, covariance, variance of direction, (K, 3).

    Parameters
    ----------
    covariances : FloatArray
        The same as the tracker states it, shape (K, 3) [m², m rad, rad²].
    scales : (float, float)
        Factors of the standard deviations of place and direction; they shrink none of an unsure
        claim.
    usual : float
        Usual variance of the place of a claim [m²]; NaN where there is none.
    """
    unsure = covariances[:, 0] > UNSURE**2 * usual
    place, direction = (np.where(unsure, max(scale, 1.0), scale) for scale in scales)
    noise: FloatArray = covariances * np.column_stack((place**2, place * direction, direction**2))
    noise[:, 0] += FLOOR**2
    noise[:, 2] += HEADING_FLOOR**2 + YAW_SIGMA**2
    return noise
