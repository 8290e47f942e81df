"""A dark strip beside a bright cable is its shadow.

A vehicle's lamp casts the shadow of a pipe beside it, and the two borders of the shadow are often
clearer than those of an old, overgrown pipe. Of the three borders in a row, the middle one belongs
to both strips. If they are a cable and its shadow, all three are to be expected; if the dark strip
is the cable, the outer border of the bright one is there by chance. So the dark strip is the less
likely of the two, by what the frame says for that outer border alone.

Only what is brighter than the bottom beyond the dark strip casts it: the gap between two dark
strips is as bright as the bottom. And where a map shows the dark strip and not the bright one, that
much less speaks for a shadow: sand beside a wide pipe may have two borders of its own.

The constants were chosen on the simulated worlds to tune on (`tune_*`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.hypotheses.weigh.association import scaled_pose_distance
from cable_tracker.cable.hypotheses.weigh.shared_borders import (
    SHARED_ANGLE,
    SHARED_OFFSET,
    parabolic_window,
    shared_border_score,
)
from cable_tracker.cable.measure.borders.likelihood_ratio import CableMeasures
from cable_tracker.cable.measure.borders.polarity_prior import BRIGHT, DARK
from cable_tracker.cable.model.geometry import border_offset, border_side, relative_direction
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, SKEW, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_loop, compiled_part

MOST_DARK = 3
"""Number of dark strips that may be shadows: those with the highest log-likelihood ratios."""

LEAST_RATIO = 6.0
"""Minimum log-likelihood ratio of a dark strip, and of the bright one beside it [nats]."""

LEAST_STEP = 2.0
"""Minimum brightness of a cable over the bottom beyond its shadow [scales of the contrast]."""

LEAST_SHARED_SCORE = 0.3
"""Minimum `shared_border_score`, 0..1, for two borders to be the same."""

RAMP = 4.0
"""Slope of the loss factor min(RAMP s, 1), s the overlap score of `_within` (1 centre, 0 border):
the full loss applies from s = 1/4."""


class ShadowRules(NamedTuple):
    """Limits of what counts as a shadow.

    Attributes
    ----------
    evidence : float
        The parameter `shadow_evidence` [nats]; infinite: nothing is a shadow.
    limit : float
        The parameter `evidence_limit` [nats], upper bound of a bright cable's ratio.
    same_radii : FloatArray
        Largest differences of d, alpha, w, beta between strips that count as one, shape (4,) [px,
        rad].
    unit : float
        Pixels of the frame per pixel at the reference width.
    """

    evidence: float
    limit: float
    same_radii: FloatArray
    unit: float


class Shadows(NamedTuple):
    """Room for the shadows of a frame.

    Attributes
    ----------
    poses : FloatArray
        d, alpha, w, beta, shape (M, 4) [px, rad].
    ceilings : FloatArray
        Upper bound of the log-likelihood ratio of a dark strip in each shadow, shape (M,) [nats].
    strips : IndexArray
        Rows of the dark strips that were looked at, shape (`MOST_DARK`,).
    """

    poses: FloatArray
    ceilings: FloatArray
    strips: IndexArray


@compiled_part
def empty_shadows() -> Shadows:
    """Return room for shadows: every dark strip may have a cable on either side."""
    most = 2 * MOST_DARK
    return Shadows(np.empty((most, POSE_SIZE)), np.empty(most), np.empty(MOST_DARK, np.int64))


@compiled_loop
def find_shadows(
    states: FloatArray,
    possible: BoolArray,
    measured: CableMeasures,
    map_log_ratios: FloatArray,
    rules: ShadowRules,
    shadows: Shadows,
) -> int:
    """Fill in the shadows among N particles, and return how many there are.

    Parameters
    ----------
    states : FloatArray
        The particles, shape (N, 8), in one chart.
    possible : BoolArray
        Whether each of them is a possible cable, shape (N,).
    measured : CableMeasures
        Their log-likelihood ratios; it may have more rows.
    map_log_ratios : FloatArray
        What the map says of them [nats]; it may have more rows.
    rules : ShadowRules
        Limits of what counts as a shadow.
    shadows : Shadows
        Buffers that are filled in.
    """
    found = 0
    for number in range(MOST_DARK):
        strip = _clearest_dark_strip(states, possible, measured, rules, shadows.strips[:number])
        if strip < 0:
            break
        shadows.strips[number] = strip
        for border in range(2):
            step = measured.outsides[strip, border] - measured.outsides[strip, 1 - border]
            if step < LEAST_STEP:
                continue
            ceiling = _ceiling_beside(
                states, possible, measured, map_log_ratios, rules, strip, border
            )
            if ceiling == math.inf:
                continue
            for column in range(POSE_SIZE):
                shadows.poses[found, column] = states[strip, column]
            shadows.ceilings[found] = ceiling
            found += 1
    return found


@compiled_loop
def _clearest_dark_strip(
    states: FloatArray,
    possible: BoolArray,
    measured: CableMeasures,
    rules: ShadowRules,
    others: IndexArray,
) -> int:
    """Return the row of the likeliest dark strip near none of the others; -1 for none.

    Both of its borders are in view: the brightness beyond one that is not is unknown.
    """
    clearest, most = -1, LEAST_RATIO
    for row in range(len(states)):
        ratio = measured.log_ratios[row, DARK]
        if ratio <= most or ratio < measured.log_ratios[row, BRIGHT] or not possible[row]:
            continue
        if measured.visible_lengths[row] == 0.0:
            continue
        is_new = True
        for other in others:
            is_new = (
                is_new and scaled_pose_distance(states[row], states[other], rules.same_radii) >= 1.0
            )
        if is_new:
            clearest, most = row, ratio
    return clearest


@compiled_loop
def _ceiling_beside(
    states: FloatArray,
    possible: BoolArray,
    measured: CableMeasures,
    map_log_ratios: FloatArray,
    rules: ShadowRules,
    strip: int,
    border: int,
) -> float:
    """Return the highest ratio of a dark strip beside the likeliest bright one on its border.

    Infinite if there is none, or if the outer border of that one says too little. Where the map
    shows the dark strip and not the bright one, the ratio may be that much higher.
    """
    side = border_side(border)
    state = states[strip]
    angle = state[ANGLE] + side * state[SKEW]
    offset = border_offset(state[DISTANCE], state[WIDTH], state[SKEW], side)
    most, outer, map_ratio = LEAST_RATIO, 0.0, 0.0
    for row in range(len(states)):
        ratio = measured.log_ratios[row, BRIGHT]
        if ratio <= most or not possible[row]:
            continue
        # The left border of a shadow is the right one of the cable.
        shared, score = shared_border_score(states[row], angle, offset, -side, rules.unit)
        if score > LEAST_SHARED_SCORE:
            most, outer = ratio, measured.bright_border_log_ratios[row, 1 - shared]
            map_ratio = map_log_ratios[row]
    speaks = outer - rules.evidence
    if speaks <= 0.0:
        return math.inf
    shown_instead: float = max(map_log_ratios[strip] - map_ratio, 0.0)
    return min(most, rules.limit) - speaks + shown_instead


@compiled_loop
def fill_shadow_losses(
    states: FloatArray,
    measured: CableMeasures,
    shadows: Shadows,
    count: int,
    unit: float,
    losses: FloatArray,
) -> bool:
    """Fill in what dark strips lose of their log-likelihood ratio; tell whether any has changed.

    Parameters
    ----------
    states, measured : FloatArray, CableMeasures
        Particles, shape (N, 8), and their log-likelihood ratios; see `find_shadows`.
    shadows, count : Shadows, int
        The shadows of the frame, and their number.
    unit : float
        See `ShadowRules`.
    losses : FloatArray
        Reduction of each particle's ratio as a dark cable, at least 0, shape (N,) [nats].
    """
    changed = False
    for row in range(len(states)):
        ratio = measured.log_ratios[row, DARK]
        before, losses[row] = losses[row], 0.0
        for index in range(count):
            above = ratio - losses[row] - shadows.ceilings[index]
            if above > 0.0:
                inside = _within(states[row], shadows.poses[index], unit)
                losses[row] += above * min(RAMP * inside, 1.0)
        changed = changed or losses[row] != before
    return changed


@compiled_inside
def _within(state: FloatArray, pose: FloatArray, unit: float) -> float:
    """Return the overlap score of a strip with another: 1 in its centre, 0 at its borders."""
    wrapped, sign = relative_direction(state[ANGLE], pose[ANGLE])
    margin = SHARED_OFFSET * unit
    apart = (sign * state[DISTANCE] - pose[DISTANCE]) / (0.5 * pose[WIDTH] + margin)
    turn = wrapped / (2.0 * SHARED_ANGLE)
    wider = max((state[WIDTH] - pose[WIDTH]) / (pose[WIDTH] + margin), 0.0)
    return parabolic_window(apart) * parabolic_window(turn) * parabolic_window(wider)
