"""Trackers with all their parts: the one place that knows both the tracker and the detectors."""

from __future__ import annotations

import numpy as np

from cable_tracker.cable.filter_interface import CableProposer, NoProposer
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.tracker import CableTracker
from cable_tracker.detection.line_pair_proposer import LinePairProposer
from cable_tracker.detection.pair_limits import pair_limits

WARM_UP_WIDTH, WARM_UP_HEIGHT = 320, 240
WARM_UP_FRAMES, WARM_UP_TOLD = 6, 5
WARM_UP_STEP = 40_000_000
"""Size of the frames for `warm_up` [px], how many, from which on the tracker has been told where
the cable is, and the time between them [ns]."""

WARM_UP_PARTICLES = 200
"""Number of particles of `warm_up`; compilation does not depend on it."""


def make_tracker(parameters: TrackerParameters) -> CableTracker:
    """Return a tracker with the detector that its parameters name.

    Raises
    ------
    ParameterError
        The response table cannot be read.
    """
    return CableTracker(parameters, make_proposer(parameters))


def warm_up(parameters: TrackerParameters) -> None:
    """Run a tracker of its own on a few frames, so that everything is compiled and loaded.

    The first time on a machine takes some seconds or more; later the machine code is on disk.

    Raises
    ------
    ParameterError
        The response table cannot be read.
    """
    count = min(parameters.particle_count, WARM_UP_PARTICLES)
    tracker = make_tracker(parameters.replaced({"particle_count": count}))
    frame = np.full((WARM_UP_HEIGHT, WARM_UP_WIDTH), 60, np.uint8)
    frame[:, WARM_UP_WIDTH // 2 - 20 : WARM_UP_WIDTH // 2 + 20] = 160
    for number in range(1, WARM_UP_FRAMES + 1):
        if number == WARM_UP_TOLD:
            tracker.initialise(GivenState.around(CableState(0.0, 0.0, 40.0)))
        tracker.process(frame, stamp=number * WARM_UP_STEP)


def make_proposer(parameters: TrackerParameters) -> CableProposer:
    """Return the detector that parameters name; the bootstrap filter asks none."""
    if parameters.filter == "bootstrap" or parameters.detector == "none":
        return NoProposer()
    return LinePairProposer(pair_limits(parameters), looks_at_map=parameters.uses_map)
