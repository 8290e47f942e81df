"""Where a frame speaks for the target: maxima of the map of log-ratios, and rivals among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.target.measure.measured_frame import MeasuredFrame
from cable_tracker.target.measure.places import find_places
from cable_tracker.target.model.state import POSE_SIZE, STATE_SIZE, PoseColumn
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.pose_belief import PoseBelief
from cable_tracker.target.poses.rivals import RIVAL_SCORE, RivalWatch, are_beside

SCALES_LOOKED_FOR = (-0.3, 0.0, 0.3)
"""Log scales against the last one at which maxima are looked for."""


class MapMaxima(NamedTuple):
    """Maxima of the filtered map of log-ratios, about which particles are proposed.

    Attributes
    ----------
    poses : FloatArray
        Place, log scale and angle, shape (K, 4).
    strengths : FloatArray
        Responses of the filter there, scaled to sum to one, shape (K,).
    """

    poses: FloatArray
    strengths: FloatArray


NO_MAXIMA = MapMaxima(np.empty((0, POSE_SIZE)), np.empty(0))


def propose_from_map(
    belief: PoseBelief, measured: MeasuredFrame, parameters: TargetParameters
) -> MapMaxima:
    """Return the maxima of a frame."""
    if parameters.place_count == 0:
        return NO_MAXIMA
    template = belief.known.template
    extent = template.extent(belief.angle)
    places = find_places(
        measured.ratios,
        (extent[0] * template.size, extent[1] * template.size),
        _scales_looked_for(belief, parameters),
        parameters.place_count,
    )
    if not places:
        return NO_MAXIMA
    poses = np.array([[place.x, place.y, place.log_scale, belief.angle] for place in places])
    strengths = np.array([place.strength for place in places])
    return MapMaxima(poses, strengths / strengths.sum())


def _scales_looked_for(belief: PoseBelief, parameters: TargetParameters) -> FloatArray:
    """Return the log scales at which maxima are looked for."""
    expected = belief.estimate
    if belief.presence < parameters.presence_to_lose:
        # The estimate is then on something else, whose size says nothing.
        expected = belief.known.births.last
    scales: FloatArray = expected[PoseColumn.LOG_SCALE] + np.array(SCALES_LOOKED_FOR)
    return scales


def watch_rivals(
    belief: PoseBelief, measured: MeasuredFrame, maxima: MapMaxima, dt: float
) -> RivalWatch:
    """Return what is known of rivals after the maxima of a frame."""
    watch = belief.rivals.aged(dt)
    poses = maxima.poses
    distances = np.hypot(*(poses[:, :2] - belief.estimate[:2]).T) / belief.size
    if not are_beside(distances):
        return watch.after(distances)
    states = np.zeros((len(poses), STATE_SIZE))
    states[:, :POSE_SIZE] = poses
    scores = measured.scores(states, belief.known.template)
    return watch.after(distances[scores >= RIVAL_SCORE * belief.known.usual.mean])
