"""How many of the particles of a frame are drawn from what."""

from __future__ import annotations

from typing import NamedTuple

from cable_tracker.arrays import IndexArray
from cable_tracker.cable.hypotheses.predict.predicted_density import PredictedDensity
from cable_tracker.cable.hypotheses.weigh.presence import LIKELY_PRESENCE
from cable_tracker.cable.parameters.parameters import (
    BORDER_SWITCH_SHARE,
    LEAST_SURVIVOR_SHARE,
    TrackerParameters,
)

LOST_DETECTOR_SHARE = 0.3
"""Share of the particles about detections while it is more likely than not that there is none."""

LARGEST_BIRTH_SHARE = 0.8
"""Share of the particles of the prior that are born at most."""


class SampleCounts(NamedTuple):
    """Numbers of particles of a frame, by the proposal that they are drawn from, before its rounds.

    Attributes
    ----------
    survivors, births, switches, detections : int
        Drawn about ancestors, from the birth density, from the border-switch density, and about
        what the detector sees.
    births_about_memory : int
        Those of the births that are drawn about the remembered cable.
    """

    survivors: int
    births: int
    births_about_memory: int
    switches: int
    detections: int


def sample_counts(
    parameters: TrackerParameters,
    density: PredictedDensity,
    detections: int,
    refined: IndexArray,
) -> SampleCounts:
    """Share out the particles of a frame with some detections that its rounds leave.

    `refined`: those that each round draws, shape (R,).
    """
    count = parameters.particle_count
    switches = int(count * BORDER_SWITCH_SHARE)
    first = count - int(refined.sum()) - switches
    share = parameters.detector_share if detections else 0.0
    existing = density.mass_survived + density.mass_born
    if share > 0.0 and existing < LIKELY_PRESENCE:
        share = max(share, LOST_DETECTOR_SHARE)
    # The raised share, too, leaves something for survivors and births.
    least = max(int(count * LEAST_SURVIVOR_SHARE), 1)
    detected = min(int(count * share), max(first - least, 0))
    rest = first - detected
    born = max(density.mass_born / existing, parameters.search_share)
    births = int(rest * min(born, LARGEST_BIRTH_SHARE))
    return SampleCounts(
        survivors=rest - births,
        births=births,
        births_about_memory=round(density.births.share * births),
        switches=switches,
        detections=detected,
    )
