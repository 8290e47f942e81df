"""What the proposals of a frame are made from: all that changes from frame to frame."""

from __future__ import annotations

from typing import NamedTuple

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.hypotheses.predict.frame_noise import FrameNoise
from cable_tracker.cable.hypotheses.predict.predicted_density import PredictedDensity
from cable_tracker.cable.hypotheses.propose.map_log_ratio import ExpectedOverlap
from cable_tracker.cable.measure.borders.likelihood_ratio import RatioModel
from cable_tracker.cable.measure.borders.polarity_prior import PolarityPrior
from cable_tracker.cable.measure.gradients.scanned_gradients import ScanInputs
from cable_tracker.cable.measure.map.cable_map import CableMap


class ProposalInputs(NamedTuple):
    """Inputs of the proposals of a frame.

    Attributes
    ----------
    predicted : PredictedDensity
        The density f before the frame is looked at.
    noise : FrameNoise
        Random numbers of the frame.
    scan, model : ScanInputs, RatioModel
        The scanned frame, and the tables of its log-likelihood ratios.
    cable_map : CableMap
        The map of the frame; beside a clear known cable the kept one, moved along; `NO_MAP` without
        either.
    expected_overlap : ExpectedOverlap
        What overlaps with this map are held against.
    polarity : PolarityPrior
        Probability that a cable is brighter than the bottom.
    reference_angle : float
        Angle within pi/2 of which the normals of all particles are written [rad].
    ancestors : IndexArray
        Index of the kernel of f that each survivor is drawn from, shape (S,).
    detected : FloatArray
        d, alpha, w, beta of cables that a detector sees [px, rad], shape (K, 4).
    anchors : FloatArray
        Expected state of the leading cluster, shape (0 or 1, 8).
    """

    predicted: PredictedDensity
    noise: FrameNoise
    scan: ScanInputs
    model: RatioModel
    cable_map: CableMap
    expected_overlap: ExpectedOverlap
    polarity: PolarityPrior
    reference_angle: float
    ancestors: IndexArray
    detected: FloatArray
    anchors: FloatArray
