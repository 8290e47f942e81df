"""What a map adds to the log-likelihood of a particle, beside a known cable and in a search.

A strip is held against the one that is expected: one that matches the map of the frame less well
than a known cable does looks less like a cable than that. In a kept map, moved along with the
cable, a strip that matches nearly as well as the expected one is as good, and borders decide.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.map.cable_map import (
    CableMap,
    bounded_log_odds,
    is_worked_out,
    map_match,
    map_overlap,
)
from cable_tracker.compilation import compiled_inside

SLACK = 1.0
"""How much less than that of the expected strip an overlap with a kept map may be that is as good
[nats]: how exactly the cable has moved since is not known."""


class MapWeights(NamedTuple):
    """How much a map counts in the likelihood [nats per nat].

    Attributes
    ----------
    overlap : float
        Weight of the overlap of a strip with the map.
    lacking : float
        Weight of what it lacks, besides, to the overlap of the expected strip.
    """

    overlap: float
    lacking: float


class ExpectedOverlap(NamedTuple):
    """What overlaps with a map are held against [nats].

    Attributes
    ----------
    enough : float
        Beyond it more is no better; infinite in the map of the frame itself.
    expected : float
        That of the strip that is expected: to match less well counts for more than to match better.
        -inf where none is.
    """

    enough: float
    expected: float


NOTHING_EXPECTED = ExpectedOverlap(math.inf, -math.inf)
"""Of a search, and where there is no map."""


def overlap_of_expected(
    cable_map: CableMap, state: FloatArray, *, is_kept: bool
) -> ExpectedOverlap:
    """Return what strips are held against beside a known cable whose expected state is (8,).

    `is_kept`: the map is of a frame before.
    """
    if not is_worked_out(cable_map):
        return NOTHING_EXPECTED
    overlap = map_overlap(state, cable_map)
    if is_kept:
        return ExpectedOverlap(enough=overlap - SLACK, expected=overlap - SLACK)
    return ExpectedOverlap(enough=math.inf, expected=overlap)


@compiled_inside
def map_log_ratio(
    state: FloatArray, cable_map: CableMap, against: ExpectedOverlap, weights: MapWeights
) -> float:
    """Return what a map adds to the log-likelihood ratio of a strip (8,), 0 for `NO_MAP` [nats]."""
    if not is_worked_out(cable_map):
        return 0.0
    overlap = bounded_log_odds(map_match(state, cable_map).overlap_share)
    lacking = max(against.expected - overlap, 0.0)
    log_ratio: float = weights.overlap * min(overlap, against.enough) - weights.lacking * lacking
    return log_ratio
