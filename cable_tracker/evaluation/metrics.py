"""Errors of estimates against ground truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.geometry import unwrap_states
from cable_tracker.cable.state import CableState
from cable_tracker.sequences.estimates import EstimateRow

ANGLE_TOLERANCE = float(np.deg2rad(8.0))
"""An estimate that is turned by more is off."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorSummary:
    """Errors over the labelled frames of a recording in which a cable was claimed.

    Attributes
    ----------
    labelled : int
        Frames with ground truth.
    claimed : int
        Those of them in which the tracker claimed a cable.
    bias, rmse, median, percentile_95 : FloatArray
        Mean, root mean square, median and 95th percentile of the (absolute) errors of d, alpha, w,
        beta, shape (4,) [px, rad]; NaN if no labelled frame was claimed.
    share_off : float
        Share of the claimed frames in which |d error| > w/2 or |alpha error| > 8 deg.
    """

    labelled: int
    claimed: int
    bias: FloatArray
    rmse: FloatArray
    median: FloatArray
    percentile_95: FloatArray
    share_off: float


def state_errors(estimate: CableState, truth: CableState) -> FloatArray:
    """Return estimate minus truth of d, alpha, w, beta, shape (4,), also across the wrap."""
    chart = unwrap_states(estimate.to_array()[None, :], truth.angle)[0]
    errors: FloatArray = chart[:4] - truth.to_array()[:4]
    return errors


def is_off(errors: FloatArray, truth: CableState) -> bool:
    """Tell whether an estimate misses the cable: off by half its width, or by 8 deg."""
    return bool(abs(errors[0]) > truth.width / 2 or abs(errors[1]) > ANGLE_TOLERANCE)


def summarise_errors(rows: Sequence[EstimateRow], truths: Mapping[int, CableState]) -> ErrorSummary:
    """Compare the rows of a tracked recording with the truths by frame number."""
    pairs = [
        (row.state, truths[row.frame])
        for row in rows
        if row.state is not None and row.frame in truths
    ]
    if not pairs:
        unknown = np.full(4, np.nan)
        return ErrorSummary(len(truths), 0, unknown, unknown, unknown, unknown, float("nan"))
    errors = np.array([state_errors(estimate, truth) for estimate, truth in pairs])
    off = [is_off(error, truth) for error, (_, truth) in zip(errors, pairs, strict=True)]
    return ErrorSummary(
        labelled=len(truths),
        claimed=len(pairs),
        bias=errors.mean(axis=0),
        rmse=np.sqrt((errors**2).mean(axis=0)),
        median=np.median(np.abs(errors), axis=0),
        percentile_95=np.percentile(np.abs(errors), 95, axis=0),
        share_off=float(np.mean(off)),
    )
