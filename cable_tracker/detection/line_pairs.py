"""Pairs of border lines that make a cable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import borders_cross_inside, pose_between, pose_in_chart
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    SKEW,
    STATE_SIZE,
    WIDTH,
    CableState,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled, compiled_loop
from cable_tracker.detection.border_lines import BorderLines, turn_between
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

REGION_SHARE = 0.5
"""Share of the minimum score that is enough inside a region, where a cable is expected anyway."""

MOST_DETECTIONS = 8

PARTNER_SHARE = 0.5
"""A line beside a border has at least this share of the border's support to be its partner."""

GAP_FACTOR = 0.5
"""Factor on the score of a pair that is the gap between two strips narrower than itself."""


class PairLimits(NamedTuple):
    """Smallest and largest cable that a detector reports.

    Attributes
    ----------
    narrowest, widest : float
        Smallest and largest w [px at the reference width].
    most_skew : float
        Largest |beta| [rad].
    """

    narrowest: float
    widest: float
    most_skew: float


def pair_limits(parameters: TrackerParameters) -> PairLimits:
    """Return limits that cover the cables that a tracker can follow."""
    return PairLimits(
        narrowest=parameters.width_minimum,
        widest=parameters.width_maximum,
        most_skew=math.radians(parameters.skew_limit),
    )


DEFAULT_LIMITS = pair_limits(TrackerParameters())
"""Limits of the preset `default`."""


@dataclass(frozen=True, slots=True)
class Detection:
    """One cable found by a detector.

    Attributes
    ----------
    state : CableState
        State of the cable [px, rad]; rates are unknown from a single picture and 0.
    score : float
        Clearness of the cable, from 0 to 1. Comparable within one detector only.
    """

    state: CableState
    score: float


def pair_lines(
    lines: BorderLines,
    image_size: tuple[int, int],
    region: SearchRegion | None,
    minimum_score: float,
    limits: PairLimits,
) -> list[Detection]:
    """Combine border lines of opposite contrast that are nearly parallel.

    Parameters
    ----------
    lines : BorderLines
        Candidates.
    image_size : (int, int)
        Width and height of the picture [px].
    region : SearchRegion or None
        Only cables in this box, if given.
    minimum_score : float
        Weaker pairs (see `plausible_pairs`) are no cables; inside a region, `REGION_SHARE` of it
        is enough.
    limits : PairLimits
        Widths and skews of cables.

    Returns
    -------
    list of Detection
        Best first, at most `MOST_DETECTIONS`.
    """
    poses, scores = plausible_pairs(
        lines.angles,
        lines.offsets,
        lines.supports,
        limits,
        (float(image_size[0]), float(image_size[1])),
    )
    states = np.zeros((len(poses), STATE_SIZE))
    states[:, :POSE_SIZE] = poses
    if region is None:
        usable = scores >= minimum_score
    else:
        usable = (scores >= REGION_SHARE * minimum_score) & region.admits(states)
    states, scores = states[usable], scores[usable]
    best = np.argsort(-scores, kind="stable")[:MOST_DETECTIONS]
    return [Detection(CableState.from_array(states[each]), float(scores[each])) for each in best]


@compiled
def plausible_pairs(
    angles: FloatArray,
    offsets: FloatArray,
    supports: FloatArray,
    limits: PairLimits,
    image_size: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    """Return the cables between lines whose normals are nearly opposite, and their scores.

    Borders that cross inside the picture are none of one cable, see `borders_cross_inside`. The
    score is the geometric mean of the supports: one strong edge does not make a cable. A pair is
    only the gap between two strips where both its lines have a partner on their outer side, nearer
    than the pair is wide: its score is multiplied by `GAP_FACTOR`.

    Parameters
    ----------
    angles, offsets, supports : FloatArray
        Angles, offsets and supports of N lines, see `BorderLines`.
    limits : PairLimits
        Widths and skews of cables.
    image_size : (float, float)
        Width and height of the picture [px].

    Returns
    -------
    poses : FloatArray
        d, alpha, w, beta of K cables [px, rad], angles in (-pi/2, pi/2], shape (K, 4).
    scores : FloatArray
        Shape (K,).
    """
    count, scale = len(angles), image_size[0] / REFERENCE_WIDTH
    narrowest, widest = limits.narrowest * scale, limits.widest * scale
    pairs = count * (count - 1) // 2
    poses, scores = np.empty((pairs, POSE_SIZE)), np.empty(pairs)
    ends = np.empty((pairs, 2), np.int64)
    bright = np.empty(pairs, np.bool_)
    # Width of the narrowest strip that a line borders with its darker and its brighter side.
    strips = np.full((count, 2), np.inf)
    found = 0
    for first in range(count):
        for second in range(first + 1, count):
            # The normals of a strip's borders are opposite: turn the second line's round.
            angle = angles[first]
            opposite = angle + turn_between(angles[second] + math.pi, angle)
            if abs(opposite - angle) / 2 > limits.most_skew:
                continue
            pose = poses[found]
            bright[found] = _cable_between(angle, offsets[first], opposite, -offsets[second], pose)
            if not narrowest <= pose[WIDTH] <= widest:
                continue
            if borders_cross_inside(pose, image_size):
                continue
            scores[found] = math.sqrt(supports[first] * supports[second])
            ends[found, 0], ends[found, 1] = first, second
            side = int(bright[found])
            if supports[second] >= PARTNER_SHARE * supports[first]:
                strips[first, side] = min(strips[first, side], pose[WIDTH])
            if supports[first] >= PARTNER_SHARE * supports[second]:
                strips[second, side] = min(strips[second, side], pose[WIDTH])
            found += 1
    for pair in range(found):
        outer = 1 - int(bright[pair])
        beside = max(strips[ends[pair, 0], outer], strips[ends[pair, 1], outer])
        if beside < poses[pair, WIDTH]:
            scores[pair] *= GAP_FACTOR
    return poses[:found], scores[:found]


@compiled_loop
def _cable_between(
    angle: float, offset: float, other: float, other_offset: float, pose: FloatArray
) -> bool:
    """Fill in d, alpha, w, beta of the cable between two lines; return whether it is bright.

    Their normals point to the same side.
    """
    bright = offset <= other_offset
    if bright:
        between = pose_between(angle, other, offset, other_offset)
    else:
        between = pose_between(other, angle, other_offset, offset)
    pose[DISTANCE], pose[ANGLE], pose[WIDTH], pose[SKEW] = between
    pose_in_chart(pose, 0.0, pose)
    return bright
