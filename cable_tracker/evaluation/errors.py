"""Errors of estimates against ground truth, and whether an estimate is off the cable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, CableState
from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.tracking.parameter_table import pixel_scale

LOST_DISTANCE = 10.0
"""An error of d that is forgiven however narrow the cable, in an image 320 px wide [px]."""

LOST_ANGLE = float(np.deg2rad(8.0))
"""An estimate that is turned by more has lost the cable [rad]."""


def forgiven_distance(image_width: int) -> float:
    """Return `LOST_DISTANCE` in images of a width [px]."""
    return LOST_DISTANCE * pixel_scale(image_width)


def forgiven_distances(image_widths: IndexArray) -> FloatArray:
    """Return `forgiven_distance` in images of several widths [px], shape (N,)."""
    return np.array([forgiven_distance(width) for width in image_widths.tolist()], np.float64)


def is_off_cable(
    errors: FloatArray, widths: FloatArray, *, forgiven: float | FloatArray
) -> BoolArray:
    """Tell whether estimates are off by more than max(forgiven, w/2) or 8 deg, shape (N,).

    An error that is no number is off.

    Parameters
    ----------
    errors : FloatArray
        Estimate minus truth of d, alpha, ..., shape (N, >= 2) [px, rad].
    widths : FloatArray
        True widths w, shape (N,) [px].
    forgiven : float or FloatArray
        Error of d that is forgiven however narrow the cable, one for all or shape (N,) [px]:
        `forgiven_distance` for what runs and tables count as a wrong claim; 0 for what is said of a
        recording with labels, a centreline outside the true borders.
    """
    allowance = np.maximum(forgiven, widths / 2)
    held = (np.abs(errors[:, DISTANCE]) <= allowance) & (np.abs(errors[:, ANGLE]) <= LOST_ANGLE)
    return np.asarray(~held)


@dataclass(frozen=True, slots=True, eq=False)
class ErrorStatistics:
    """Errors of d, alpha, w, beta over some frames, shape (4,) each [px, rad]; NaN over none.

    Attributes
    ----------
    bias, rmse : FloatArray
        Mean and root mean square of estimate minus truth.
    median, percentile_95 : FloatArray
        Median and 95th percentile of the absolute errors, shape (4,) [px, rad].
    """

    bias: FloatArray
    rmse: FloatArray
    median: FloatArray
    percentile_95: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ErrorSummary:
    """Errors over the labelled frames of a recording in which a cable was claimed.

    Attributes
    ----------
    labelled : int
        Frames with ground truth.
    claimed : int
        Number of these frames with a claimed cable.
    errors : ErrorStatistics
        Errors of the claimed frames.
    share_off : float
        Share of the claimed frames in which the estimate `is_off_cable`, nothing forgiven: outside
        the true borders; NaN if none was claimed.
    """

    labelled: int
    claimed: int
    errors: ErrorStatistics
    share_off: float


def state_errors(estimate: CableState, truth: CableState) -> FloatArray:
    """Return estimate minus truth of d, alpha, w, beta, shape (4,), also across the wrap."""
    chart = wrap_state(estimate.to_array(), truth.angle)
    errors: FloatArray = chart[:POSE_SIZE] - truth.to_array()[:POSE_SIZE]
    return errors


def error_statistics(errors: FloatArray) -> ErrorStatistics:
    """Summarise errors of shape (K, 4); rows that are not finite are left out."""
    finite = errors[np.isfinite(errors).all(axis=1)]
    if not len(finite):
        unknown = np.full(POSE_SIZE, np.nan)
        return ErrorStatistics(unknown, unknown, unknown, unknown)
    return ErrorStatistics(
        bias=finite.mean(axis=0),
        rmse=np.sqrt((finite**2).mean(axis=0)),
        median=np.median(np.abs(finite), axis=0),
        percentile_95=np.percentile(np.abs(finite), 95, axis=0),
    )


def summarise_errors(rows: Sequence[EstimateRow], truths: Mapping[int, CableState]) -> ErrorSummary:
    """Compare the rows of a tracked recording with the truths by frame number."""
    pairs = [
        (row.state, truths[row.frame])
        for row in rows
        if row.state is not None and row.frame in truths
    ]
    errors = np.array([state_errors(estimate, truth) for estimate, truth in pairs])
    errors = errors.reshape(-1, POSE_SIZE)
    off = is_off_cable(errors, np.array([truth.width for _, truth in pairs]), forgiven=0.0)
    return ErrorSummary(
        labelled=len(truths),
        claimed=len(pairs),
        errors=error_statistics(errors),
        share_off=mean(off),
    )
