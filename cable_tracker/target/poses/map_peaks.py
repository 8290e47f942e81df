"""Peaks of the map of log-ratios, where the target may be, and rivals among them."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.target.measure.region import MeasuredFrame
from cable_tracker.target.model.state import LOG_SCALE, POSE_SIZE, X, Y, at_rest, distances_from
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.pose_belief import RIVAL_SCORE, PoseBelief, RivalWatch, are_beside

COARSENESS = 4
"""Pixels of the working image a pixel of the coarse map."""

SURROUND = 2.0
"""Side of what is around the target against its own."""

SURROUND_WEIGHT = 0.6
"""Factor on the mean log-ratio around the target, which is subtracted from that within."""

ELLIPSE_SIDE = 0.87
"""Side of the box of an ellipse's area, over that of the box about it: about the root of pi/4."""

SEARCHED_SCALES = (-0.3, 0.0, 0.3)
"""Log scales against the last one at which peaks are searched."""


class PeakPoses(NamedTuple):
    """Peaks of the filtered map of log-ratios, about which particles are proposed.

    Attributes
    ----------
    poses : FloatArray
        Place, log scale and angle, shape (K, 4).
    strengths : FloatArray
        Mean log-ratio within less that around, shape (K,).
    """

    poses: FloatArray
    strengths: FloatArray


NO_PEAKS = PeakPoses(np.empty((0, POSE_SIZE)), np.empty(0))


def propose_from_map(
    belief: PoseBelief, measured: MeasuredFrame, parameters: TargetParameters
) -> PeakPoses:
    """Return the peaks of a frame."""
    if parameters.place_count == 0:
        return NO_PEAKS
    template = belief.known.template
    extent = template.extent(belief.angle)
    return find_peaks(
        measured.ratios,
        (extent[0] * template.size, extent[1] * template.size),
        _searched_scales(belief, parameters),
        parameters.place_count,
        belief.angle,
    )


def find_peaks(
    ratios: NDArray[np.float32],
    half_extent: tuple[float, float],
    log_scales: FloatArray,
    count: int,
    angle: float = 0.0,
) -> PeakPoses:
    """Return the strongest peaks, at most `count` a scale, strongest first.

    Parameters
    ----------
    ratios : array
        Map of log-ratios, float32, shape (H, W).
    half_extent : (float, float)
        Half width and height of the target at scale 1 [px].
    log_scales : FloatArray
        Scales to search, shape (K,).
    count : int
        Peaks for every scale.
    angle : float
        Angle of the poses [rad].
    """
    height, width = ratios.shape
    small = (-(-width // COARSENESS), -(-height // COARSENESS))
    coarse = cv2.resize(ratios, small, interpolation=cv2.INTER_AREA)
    peaks: list[tuple[float, ...]] = []
    for log_scale in log_scales:
        factor = float(np.exp(log_scale)) * 2.0 / COARSENESS
        # Nothing in view is larger than the picture, whatever is believed of its size.
        sides = [
            min(max(ELLIPSE_SIDE * half * factor, 1.0), float(side))
            for half, side in zip(half_extent, small, strict=True)
        ]
        inner = cv2.boxFilter(coarse, -1, _kernel(sides, 1.0), borderType=cv2.BORDER_REPLICATE)
        outer = cv2.boxFilter(coarse, -1, _kernel(sides, SURROUND), borderType=cv2.BORDER_REPLICATE)
        response = inner - SURROUND_WEIGHT * outer
        reach = [max(int(side / 2), 1) for side in sides]
        for _ in range(count):
            row, column = divmod(int(response.argmax()), small[0])
            strength = float(response[row, column])
            if strength <= 0.0:
                break
            x = (column + 0.5) * width / small[0] - 0.5 - (width - 1) / 2
            y = (height - 1) / 2 - (row + 0.5) * height / small[1] + 0.5
            peaks.append((x, y, float(log_scale), angle, strength))
            response[
                max(row - reach[1], 0) : row + reach[1] + 1,
                max(column - reach[0], 0) : column + reach[0] + 1,
            ] = -np.inf
    found = np.array(sorted(peaks, key=lambda peak: -peak[-1])).reshape(-1, POSE_SIZE + 1)
    return PeakPoses(found[:, :POSE_SIZE], found[:, POSE_SIZE])


def _kernel(sides: list[float], factor: float) -> tuple[int, int]:
    """Return odd sides near those wanted."""
    return (2 * round((sides[0] * factor - 1) / 2) + 1, 2 * round((sides[1] * factor - 1) / 2) + 1)


def _searched_scales(belief: PoseBelief, parameters: TargetParameters) -> FloatArray:
    """Return the log scales at which peaks are searched."""
    expected = belief.estimate
    if belief.presence < parameters.presence_to_lose:
        # The estimate is then on something else, whose size is no evidence.
        expected = belief.known.births.last
    scales: FloatArray = expected[LOG_SCALE] + np.array(SEARCHED_SCALES)
    return scales


def watch_rivals(
    belief: PoseBelief, measured: MeasuredFrame, peaks: PeakPoses, dt: float
) -> RivalWatch:
    """Return the watch on rivals after the peaks of a frame."""
    watch = belief.rivals.aged(dt)
    poses = peaks.poses
    distances = distances_from(belief.estimate[X], belief.estimate[Y], poses) / belief.size
    if not are_beside(distances):
        return watch.after(distances)
    scores = measured.scores(at_rest(poses), belief.known.template)
    return watch.after(distances[scores >= RIVAL_SCORE * belief.known.usual.mean])
