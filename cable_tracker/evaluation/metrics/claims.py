"""Whether a run said rightly that there is a cable."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.evaluation.trace import Trace


@dataclass(frozen=True, slots=True)
class ClaimStatistics:
    """Whether the method says rightly that there is a cable; NaN where there is no such frame.

    Attributes
    ----------
    false_tracking : float
        Share of the frames without a visible cable in which one is claimed, 0 to 1.
    silence : float
        Share of the frames with a visible cable in which none is claimed, 0 to 1.
    wrong_claims : float
        Share of the claims on frames with a visible cable that are off it, 0 to 1; of the claims,
        not of the frames.
    useful : float
        Share of the frames with a visible cable in which it is claimed, and rightly, 0 to 1.
    """

    false_tracking: float
    silence: float
    wrong_claims: float
    useful: float


def claim_statistics(trace: Trace) -> ClaimStatistics:
    """Summarise the claims of a run."""
    claimed, visible = trace.claimed, trace.visible
    return ClaimStatistics(
        false_tracking=mean(claimed[trace.hidden]),
        silence=mean(~claimed[visible]),
        wrong_claims=mean(trace.off[visible & claimed]),
        useful=mean(trace.useful[visible]),
    )
