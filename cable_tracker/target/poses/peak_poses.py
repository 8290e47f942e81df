"""Where a frame speaks for the target: peaks of the map of log-ratios, and rivals among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.target.measure.map_peaks import find_peaks
from cable_tracker.target.measure.measured_frame import MeasuredFrame
from cable_tracker.target.model.state import LOG_SCALE, POSE_SIZE, X, Y, at_rest, distances_from
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.pose_belief import PoseBelief
from cable_tracker.target.poses.rivals import RIVAL_SCORE, RivalWatch, are_beside

SCALES_LOOKED_FOR = (-0.3, 0.0, 0.3)
"""Log scales against the last one at which peaks are looked for."""


class PeakPoses(NamedTuple):
    """Peaks of the filtered map of log-ratios, about which particles are proposed.

    Attributes
    ----------
    poses : FloatArray
        Place, log scale and angle, shape (K, 4).
    strengths : FloatArray
        Responses of the filter there, scaled to sum to one, shape (K,).
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
    peaks = find_peaks(
        measured.ratios,
        (extent[0] * template.size, extent[1] * template.size),
        _scales_looked_for(belief, parameters),
        parameters.place_count,
    )
    if not peaks:
        return NO_PEAKS
    poses = np.array([[peak.x, peak.y, peak.log_scale, belief.angle] for peak in peaks])
    strengths = np.array([peak.strength for peak in peaks])
    return PeakPoses(poses, strengths / strengths.sum())


def _scales_looked_for(belief: PoseBelief, parameters: TargetParameters) -> FloatArray:
    """Return the log scales at which peaks are looked for."""
    expected = belief.estimate
    if belief.presence < parameters.presence_to_lose:
        # The estimate is then on something else, whose size says nothing.
        expected = belief.known.births.last
    scales: FloatArray = expected[LOG_SCALE] + np.array(SCALES_LOOKED_FOR)
    return scales


def watch_rivals(
    belief: PoseBelief, measured: MeasuredFrame, peaks: PeakPoses, dt: float
) -> RivalWatch:
    """Return what is known of rivals after the peaks of a frame."""
    watch = belief.rivals.aged(dt)
    poses = peaks.poses
    distances = distances_from(belief.estimate[X], belief.estimate[Y], poses) / belief.size
    if not are_beside(distances):
        return watch.after(distances)
    scores = measured.scores(at_rest(poses), belief.known.template)
    return watch.after(distances[scores >= RIVAL_SCORE * belief.known.usual.mean])
