"""Trackers with all their parts: the one place that knows both the tracker and the detectors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cable_tracker.cable.parameters import TrackerParameters
from cable_tracker.cable.proposer import CableProposer, NoProposer
from cable_tracker.cable.tracker import CableTracker
from cable_tracker.detection.line_pair_proposer import LinePairProposer

PROPOSERS: Mapping[str, Callable[[], CableProposer]] = MappingProxyType(
    {"none": NoProposer, "line_pairs": LinePairProposer}
)
"""The detectors that the parameter `detector` can name."""


def make_tracker(parameters: TrackerParameters) -> CableTracker:
    """Return a tracker with the detector that its parameters name.

    Raises
    ------
    ParameterError
        The response table cannot be read.
    """
    return CableTracker(parameters, make_proposer(parameters))


def make_proposer(parameters: TrackerParameters) -> CableProposer:
    """Return the detector that parameters name."""
    return PROPOSERS[parameters.detector]()
