"""Everything that is measured about one run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.evaluation.metrics.claims import ClaimStatistics, claim_statistics
from cable_tracker.evaluation.metrics.consistency import (
    ConsistencyStatistics,
    consistency_statistics,
)
from cable_tracker.evaluation.metrics.errors import ErrorStatistics, error_statistics
from cable_tracker.evaluation.metrics.initialisation import StartStatistics, start_statistics
from cable_tracker.evaluation.metrics.losses import LossStatistics, loss_statistics
from cable_tracker.evaluation.metrics.redetection import ReturnStatistics, return_statistics
from cable_tracker.evaluation.trace import Trace


@dataclass(frozen=True, slots=True, eq=False)
class RunMetrics:
    """Everything that is measured about one run.

    Attributes
    ----------
    frame_count, visible_count : int
        Frames of the run, and those of them that show a cable.
    errors : ErrorStatistics
        Over all visible frames, also those in which the mean is off or not claimed.
    held_errors : ErrorStatistics
        Errors of the visible frames in which the mean is not off, claimed or not.
    loss, claims, consistency, returns, start : see there
        `start` is None where the method was told where the cable is.
    ms_median, ms_95 : float
        Median and 95th percentile of the time per frame [ms].
    """

    frame_count: int
    visible_count: int
    errors: ErrorStatistics
    held_errors: ErrorStatistics
    loss: LossStatistics
    claims: ClaimStatistics
    consistency: ConsistencyStatistics
    returns: ReturnStatistics
    start: StartStatistics | None
    ms_median: float
    ms_95: float


def run_metrics(trace: Trace, *, started_at_random: bool) -> RunMetrics:
    """Measure a run.

    Parameters
    ----------
    trace : Trace
        At least one frame.
    started_at_random : bool
        Whether the method had to find the cable by itself.
    """
    visible = trace.visible
    return RunMetrics(
        frame_count=len(trace),
        visible_count=int(visible.sum()),
        errors=error_statistics(trace.errors[visible]),
        held_errors=error_statistics(trace.errors[visible & ~trace.off]),
        loss=loss_statistics(trace),
        claims=claim_statistics(trace),
        consistency=consistency_statistics(trace),
        returns=return_statistics(trace),
        start=start_statistics(trace) if started_at_random else None,
        ms_median=float(np.median(trace.ms)),
        ms_95=float(np.percentile(trace.ms, 95)),
    )
