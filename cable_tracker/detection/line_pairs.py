"""Pairs of border lines that make a cable."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.model.geometry import Borders, states_from_borders, wrap_states
from cable_tracker.cable.model.state import STATE_SIZE, CableState, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.detection.border_lines import BorderLines, turn_between
from cable_tracker.detection.detector import Detection
from cable_tracker.detection.search_region import SearchRegion

WIDTH_RANGE = (8.0, 120.0)
"""Smallest and largest w of a pair [px at the reference width]."""

SKEW_LIMIT = float(np.deg2rad(15.0))
"""Largest |beta| of a pair."""

REGION_SHARE = 0.5
"""Share of the minimum score that is enough inside a region, where a cable is expected anyway."""

MOST_DETECTIONS = 8


def pair_lines(
    lines: BorderLines,
    image_size: tuple[int, int],
    region: SearchRegion | None,
    minimum_score: float,
) -> list[Detection]:
    """Combine border lines of opposite contrast that are nearly parallel.

    The score of a pair is the geometric mean of the supports of its borders: one strong edge does
    not make a cable.

    Parameters
    ----------
    lines : BorderLines
        Candidates.
    image_size : (int, int)
        Width and height of the picture [px].
    region : SearchRegion or None
        Only cables in this box, if given.
    minimum_score : float
        Weaker pairs are no cables; inside a region, `REGION_SHARE` of it is enough.

    Returns
    -------
    list of Detection
        Best first, at most `MOST_DETECTIONS`.
    """
    first, second = (np.asarray(index, np.int64) for index in np.triu_indices(len(lines), k=1))
    states = states_of_pairs(lines, first, second)
    scores = np.sqrt(lines.supports[first] * lines.supports[second])
    usable = _is_plausible(states, image_size)
    if region is None:
        usable &= scores >= minimum_score
    else:
        usable &= (scores >= REGION_SHARE * minimum_score) & region.admits(states)
    return ranked_detections(states[usable], scores[usable])


def ranked_detections(states: FloatArray, scores: FloatArray) -> list[Detection]:
    """Return cables (N, 8) with scores (N,) as detections, best first."""
    order = np.argsort(-scores, kind="stable")[:MOST_DETECTIONS]
    return [
        Detection(CableState.from_array(states[index]), float(scores[index])) for index in order
    ]


def states_of_pairs(lines: BorderLines, first: IndexArray, second: IndexArray) -> FloatArray:
    """Return the cables (K, 8) between lines, with the angle in (-pi/2, pi/2]."""
    angle, offset = lines.angles[first], lines.offsets[first]
    # The normals of a strip's borders are opposite: turn the second line's round.
    other_offset = -lines.offsets[second]
    other_angle = angle + turn_between(lines.angles[second] + np.pi, angle)
    is_left = offset <= other_offset
    borders = Borders(
        angles=np.stack(
            (np.where(is_left, angle, other_angle), np.where(is_left, other_angle, angle)), axis=1
        ),
        offsets=np.stack(
            (np.minimum(offset, other_offset), np.maximum(offset, other_offset)), axis=1
        ),
    )
    states = np.zeros((len(angle), STATE_SIZE))
    states[:, :4] = states_from_borders(borders)
    return wrap_states(states)


def _is_plausible(states: FloatArray, image_size: tuple[int, int]) -> BoolArray:
    scale = image_size[0] / REFERENCE_WIDTH
    width = states[:, StateColumn.WIDTH]
    plausible: BoolArray = (
        (width >= WIDTH_RANGE[0] * scale)
        & (width <= WIDTH_RANGE[1] * scale)
        & (np.abs(states[:, StateColumn.SKEW]) <= SKEW_LIMIT)
    )
    return plausible
