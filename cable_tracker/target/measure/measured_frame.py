"""A frame seen with the learnt appearance of a target: what poses are scored by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.target.measure.appearance import Appearance
from cable_tracker.target.measure.features import BinMap, bins_of, looked_up
from cable_tracker.target.measure.region import HueModel, score_poses
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.template import Template
from cable_tracker.target.parameters.parameters import TargetParameters


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredFrame:
    """What a frame shows of a target's appearance.

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
        """Return how much the regions of poses (N, 6) look like the target, shape (N,)."""
        scores: FloatArray = score_poses(
            self.ratios, states, template.inside, template.around, template.size, self.hues
        )
        return scores


def measure_frame(
    frame: WorkingFrame, appearance: Appearance, parameters: TargetParameters
) -> MeasuredFrame:
    """Look at a frame with what has been learnt of a target's appearance."""
    share = parameters.first_look_share
    bins = bins_of(frame.channels, appearance.bins.lookups)
    weight = parameters.hue_weight if frame.is_coloured else parameters.grey_hue_weight
    hues = HueModel(bins, appearance.hue_roots(share), weight)
    ratios = looked_up(bins, appearance.log_ratios(parameters.ratio_limit, share))
    return MeasuredFrame(frame, bins, ratios, hues)
