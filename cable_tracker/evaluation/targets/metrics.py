"""Metrics of one run: claimed boxes of a target against the true ones, frame by frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.target.model.estimate import Box

ENOUGH_OVERLAP = 0.5
"""Intersection over union of the boxes above which a frame is a success."""

RETURN_FRAMES = 15
"""Number of frames within which a target that comes back should be found."""

OWN_FRAMES = 20
"""Number of frames, the last after a crossing, that tell which target the box is on."""


@dataclass(frozen=True, slots=True)
class EvaluatedClaim:
    """One frame of a run.

    Attributes
    ----------
    truth : Box or None
        True box of the visible part of the target [px]; None while it is out of view.
    claim : Box or None
        None where no target is claimed.
    twin : Box or None
        True box of a second target of the same appearance [px].
    ms : float
        Processor time [ms].
    number : int
        Number of the frame in the run: between two, others may not count.
    """

    truth: Box | None
    claim: Box | None
    twin: Box | None
    ms: float
    number: int


def overlap(one: Box | None, two: Box | None) -> float:
    """Return the intersection of two boxes over their union; 0 without one of them."""
    if one is None or two is None:
        return 0.0
    width = min(one[2], two[2]) - max(one[0], two[0])
    height = min(one[3], two[3]) - max(one[1], two[1])
    if width <= 0.0 or height <= 0.0:
        return 0.0
    both = width * height
    areas = sum((box[2] - box[0]) * (box[3] - box[1]) for box in (one, two))
    return both / (areas - both)


def success(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view whose box overlaps enough; NaN if none is in view."""
    return mean([overlap(c.truth, c.claim) > ENOUGH_OVERLAP for c in claims if c.truth])


def centred(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view whose box is centred within half the target's size.

    The size is the mean of width and height. NaN if none is in view.
    """
    return mean([_is_centred(c.truth, c.claim) for c in claims if c.truth])


def _is_centred(truth: Box, claim: Box | None) -> bool:
    if claim is None:
        return False
    across, down = ((claim[k] + claim[k + 2] - truth[k] - truth[k + 2]) / 2.0 for k in (0, 1))
    size = (truth[2] - truth[0] + truth[3] - truth[1]) / 2.0
    return math.hypot(across, down) < size / 2.0


def claimed_in_view(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames in view in which a target is claimed; NaN if none is."""
    return mean([c.claim is not None for c in claims if c.truth])


def claimed_while_absent(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of frames without the target in which it is claimed; NaN without such."""
    return mean([c.claim is not None for c in claims if c.truth is None])


def returns_found(claims: Sequence[EvaluatedClaim]) -> list[bool]:
    """Return, for every return into view, whether the target was found in time."""
    found = []
    for index in range(1, len(claims)):
        if claims[index].truth is not None and claims[index - 1].truth is None:
            last = claims[index].number + RETURN_FRAMES
            in_view = takewhile(lambda c: c.truth is not None, claims[index:])
            soon = [c for c in in_view if c.number <= last]
            found.append(any(overlap(c.truth, c.claim) > ENOUGH_OVERLAP for c in soon))
    return found


def share_on_own_target(claims: Sequence[EvaluatedClaim]) -> float:
    """Return the share of the last frames whose box is the target's rather than its twin's."""
    last = [c for c in claims[-OWN_FRAMES:] if c.truth and c.twin]
    return mean([overlap(c.truth, c.claim) > overlap(c.twin, c.claim) for c in last])
