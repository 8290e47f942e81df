"""Scores of poses in a frame, by the learnt appearance of a target.

A score is the mean log-ratio within a region less that around it, with the likeness of its hues.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled, compiled_inside
from cable_tracker.target.measure.appearance import Appearance, BinMap, bins_of, looked_up
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.state import ANGLE, LOG_SCALE, X, Y
from cable_tracker.target.model.template import Template
from cable_tracker.target.parameters.parameters import TargetParameters

MIN_SHARE = 0.05
"""Smallest share of a region's points in the picture for a score."""

NO_SCORE = -10.0


@compiled_inside
def _pixel_of(
    point: FloatArray,
    place: tuple[float, float],
    turn: tuple[float, float],
    width: int,
    height: int,
) -> tuple[int, int]:
    """Return the column and row of a template's point at a pose; it may lie beyond the picture.

    Parameters
    ----------
    point : FloatArray
        The point in units of the template, shape (2,).
    place : (float, float)
        Origin of the template from the image centre, y up [px].
    turn : (float, float)
        Length of a unit times cosine and sine of the pose's angle [px].
    width, height : int
        Size of the picture [px].
    """
    across, up = point[0], point[1]
    column = math.floor((width - 1) * 0.5 + place[0] + turn[0] * across - turn[1] * up + 0.5)
    row = math.floor((height - 1) * 0.5 - place[1] - turn[1] * across - turn[0] * up + 0.5)
    return column, row


@compiled_inside
def _mean_around(
    ratios: NDArray[np.float32],
    points: FloatArray,
    place: tuple[float, float],
    turn: tuple[float, float],
) -> float:
    """Return the mean ratio at points of a pose; 0 where none is within the picture."""
    height, width = ratios.shape
    total = 0.0
    within = 0
    for index in range(len(points)):
        column, row = _pixel_of(points[index], place, turn, width, height)
        if 0 <= column < width and 0 <= row < height:
            total += ratios[row, column]
            within += 1
    return total / max(within, 1)


class HueModel(NamedTuple):
    """The histogram of hues that regions are compared with.

    Attributes
    ----------
    bins : array
        Bin of every pixel, uint16, shape (H, W).
    roots : FloatArray
        Roots of the target's shares of the hues, shape (K,).
    weight : float
        Score of hues that agree fully.
    """

    bins: NDArray[np.uint16]
    roots: FloatArray
    weight: float


@compiled_inside
def _interior_statistics(
    ratios: NDArray[np.float32],
    hues: HueModel,
    counts: FloatArray,
    points: FloatArray,
    place: tuple[float, float],
    turn: tuple[float, float],
) -> tuple[float, float, float]:
    """Return the mean ratio inside a pose, the share of it within the picture, and its likeness.

    The likeness is the Bhattacharyya coefficient of its hues with the target's; `counts`, shape
    (K,), is overwritten.
    """
    height, width = ratios.shape
    kinds = len(counts)
    counts[:] = 0.0
    sum_of_ratios = 0.0
    within = 0
    for index in range(len(points)):
        column, row = _pixel_of(points[index], place, turn, width, height)
        if 0 <= column < width and 0 <= row < height:
            sum_of_ratios += ratios[row, column]
            counts[hues.bins[row, column] % kinds] += 1.0
            within += 1
    if within == 0:
        return 0.0, 0.0, 0.0
    likeness = 0.0
    for hue in range(kinds):
        if counts[hue] > 0.0:
            likeness += math.sqrt(counts[hue]) * hues.roots[hue]
    return sum_of_ratios / within, within / len(points), likeness / math.sqrt(within)


@compiled
def score_poses(
    ratios: NDArray[np.float32],
    states: FloatArray,
    inside: FloatArray,
    around: FloatArray,
    size: float,
    hues: HueModel,
) -> FloatArray:
    """Return the score of every pose, shape (N,).

    Mean log-ratio inside less that around, and how far the hues inside are those of the target. Of
    a target that is partly beyond the picture, the part in view counts, by the root of its share.

    Parameters
    ----------
    ratios : array
        log p(pixel | target) / p(pixel | surroundings), float32, shape (H, W).
    states : FloatArray
        Poses, shape (N, 6).
    inside, around : FloatArray
        Points of the template, in units.
    size : float
        Length of a unit at scale 1 [px].
    hues : HueModel
        Hues of frame and target.
    """
    scores = np.empty(len(states))
    counts = np.empty(len(hues.roots))
    for row in range(len(states)):
        place = (states[row, X], states[row, Y])
        length = size * math.exp(states[row, LOG_SCALE])
        turn = (length * math.cos(states[row, ANGLE]), length * math.sin(states[row, ANGLE]))
        mean, share, likeness = _interior_statistics(ratios, hues, counts, inside, place, turn)
        if share < MIN_SHARE:
            scores[row] = NO_SCORE
            continue
        ring = _mean_around(ratios, around, place, turn)
        scores[row] = math.sqrt(share) * (mean - ring + hues.weight * likeness)
    return scores


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredFrame:
    """A frame measured by a target's appearance: a log-ratio for each pixel.

    Attributes
    ----------
    frame : WorkingFrame
        The frame.
    bins : BinMap
        Bins of its pixels.
    ratios : array
        log p(pixel | target) / p(pixel | surroundings), float32, shape (H, W).
    hues : HueModel
        Hues of the target, with which the histogram of a whole region is compared.
    """

    frame: WorkingFrame
    bins: BinMap
    ratios: NDArray[np.float32]
    hues: HueModel

    def scores(self, states: FloatArray, template: Template) -> FloatArray:
        """Return the scores of the regions of poses (N, 6), shape (N,); see `score_poses`."""
        scores: FloatArray = score_poses(
            self.ratios, states, template.inside, template.around, template.size, self.hues
        )
        return scores


def measure_frame(
    frame: WorkingFrame, appearance: Appearance, parameters: TargetParameters
) -> MeasuredFrame:
    """Return the log-ratios and hues of a frame by a target's appearance."""
    share = parameters.first_look_share
    bins = bins_of(frame.channels, appearance.bins.lookups)
    weight = parameters.hue_weight if frame.is_coloured else parameters.grey_hue_weight
    hues = HueModel(bins, appearance.hue_roots(share), weight)
    ratios = looked_up(bins, appearance.log_ratios(parameters.ratio_limit, share))
    return MeasuredFrame(frame, bins, ratios, hues)
