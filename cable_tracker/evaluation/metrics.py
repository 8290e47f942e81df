"""Errors of estimates against ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from statistics import NormalDist

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.trace import COMPONENTS, LOST_ANGLE, Trace, spans
from cable_tracker.sequences.estimates import EstimateRow
from cable_tracker.stamps import NANOSECONDS

ANGLE_TOLERANCE = LOST_ANGLE
"""An estimate that is turned by more is off [rad]."""

START_FRAMES = 30
"""A start succeeds if the cable is claimed, and rightly, within so many frames that show it."""

CLEARLY_BACK = 0.3
"""A cable that was out of view is back when so large a share of its borders can be seen."""

RETURN_SECONDS = 1.0
"""It is found again if it is claimed, and rightly, within so much time after that [s]."""

REGION_NEES = 9.4877
"""95th percentile of the chi-square distribution of 4 degrees of freedom."""


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
    """Tell whether errors (4,) [px, rad] miss the cable: off by half its width, or by 8 deg."""
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


class StartOutcome(str, Enum):
    """How a start without knowledge of the cable went."""

    RIGHT = "right"
    """The cable was claimed, and rightly, within `START_FRAMES` frames."""

    WRONG = "wrong"
    """Within that time there were claims, but only of something else: a wrong lock."""

    NONE = "none"
    """There was no claim in time."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorStatistics:
    """Errors of d, alpha, w, beta over some frames, shape (4,) each [px, rad]; NaN over none.

    Attributes
    ----------
    bias, rmse : FloatArray
        Mean and root mean square of estimate minus truth.
    median, percentile_95 : FloatArray
        Of the absolute errors.
    """

    bias: FloatArray
    rmse: FloatArray
    median: FloatArray
    percentile_95: FloatArray


@dataclass(frozen=True, slots=True)
class LossEpisode:
    """A stretch of visible frames in which the cable was not claimed rightly.

    Attributes
    ----------
    start : int
        Place of its first frame in the run.
    frame_count : int
        Number of its frames.
    seconds : float
        From its first frame to the first one on the cable again, or to the end [s].
    recovered : bool
        Whether the method found back while the cable remained visible.
    """

    start: int
    frame_count: int
    seconds: float
    recovered: bool


@dataclass(frozen=True, slots=True)
class LossStatistics:
    """How much of a visible cable was lost, silence included; NaN where no frame shows one.

    Attributes
    ----------
    share : float
        Share of the visible frames in which the cable is not claimed rightly, 0 to 1.
    longest_frames : float
        Frames of the longest loss.
    longest_seconds : float
        Its duration [s].
    recovery_seconds : float
        Mean duration of the losses that were recovered from [s]; NaN if there was none.
    unrecovered : float
        Number of losses that lasted until the cable left or the run ended.
    """

    share: float
    longest_frames: float
    longest_seconds: float
    recovery_seconds: float
    unrecovered: float


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
        Share of the claims on frames with a visible cable that are off it, 0 to 1.
    useful : float
        Share of the frames with a visible cable in which it is claimed, and rightly, 0 to 1.
    """

    false_tracking: float
    silence: float
    wrong_claims: float
    useful: float


@dataclass(frozen=True, slots=True, eq=False)
class ConsistencyStatistics:
    """Whether errors are as large as the covariance says, over claimed and visible frames.

    Attributes
    ----------
    nees_mean, nees_median : float
        Normalised squared error of (d, alpha, w, beta): 4 and 3.36 if the covariance is right,
        larger if it is too small; NaN over no frames.
    inside : FloatArray
        Share of the truths inside two sigma, shape (4,): 0.954 if the covariance is right.
    inside_region : float
        Share of the truths inside the ellipsoid of (d, alpha, w, beta) that should hold 95 %.
    """

    nees_mean: float
    nees_median: float
    inside: FloatArray
    inside_region: float


@dataclass(frozen=True, slots=True)
class StartStatistics:
    """How a start at random went.

    Attributes
    ----------
    outcome : StartOutcome or None
        None if no frame shows a cable.
    frames_to_right : float
        Number of visible frames until the first right claim, from 1; NaN if there was none.
    visibility : float
        Mean share of the borders that can be seen over the frames that the start is judged by, the
        first `START_FRAMES` that show a cable, 0 to 1; NaN if none does.
    """

    outcome: StartOutcome | None
    frames_to_right: float
    visibility: float


@dataclass(frozen=True, slots=True)
class CableReturn:
    """A cable that came back into view and stayed there for `RETURN_SECONDS` at least.

    Attributes
    ----------
    start : int
        Place in the run of the first frame with a visibility of `CLEARLY_BACK`.
    seconds : float
        From there to the first right claim, 0 if it was claimed before; NaN if there was none in
        `RETURN_SECONDS` [s].
    """

    start: int
    seconds: float


@dataclass(frozen=True, slots=True)
class ReturnStatistics:
    """How often a cable that came back into view was found again.

    Attributes
    ----------
    count : float
        Number of returns.
    found : float
        Share of them that were found again within `RETURN_SECONDS`, 0 to 1; NaN without a return.
    seconds : float
        Mean time until these were found [s]; NaN without one.
    """

    count: float
    found: float
    seconds: float


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
        Over the visible frames in which the mean is not off, claimed or not.
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


def error_statistics(errors: FloatArray) -> ErrorStatistics:
    """Summarise errors of shape (K, 4); rows that are not finite are left out."""
    finite = errors[np.isfinite(errors).all(axis=1)]
    if not len(finite):
        unknown = np.full(COMPONENTS, np.nan)
        return ErrorStatistics(unknown, unknown, unknown, unknown)
    return ErrorStatistics(
        bias=finite.mean(axis=0),
        rmse=np.sqrt((finite**2).mean(axis=0)),
        median=np.median(np.abs(finite), axis=0),
        percentile_95=np.percentile(np.abs(finite), 95, axis=0),
    )


def loss_episodes(trace: Trace) -> list[LossEpisode]:
    """Return the losses of a run, in order.

    Frames that are not judged do not interrupt a loss; frames without a cable end it.
    """
    judged = np.flatnonzero(trace.visible | trace.hidden)
    lost, visible = trace.lost[judged], trace.visible[judged]
    stamps = trace.stamps[judged] / NANOSECONDS
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    episodes = []
    for start, end in spans(lost):
        recovered = end < len(judged) and bool(visible[end])
        until = stamps[end] if recovered else stamps[end - 1] + period
        episodes.append(
            LossEpisode(int(judged[start]), end - start, float(until - stamps[start]), recovered)
        )
    return episodes


def loss_statistics(trace: Trace) -> LossStatistics:
    """Summarise the losses of a run."""
    visible = trace.visible
    if not visible.any():
        return LossStatistics(math.nan, math.nan, math.nan, math.nan, math.nan)
    episodes = loss_episodes(trace)
    recoveries = [episode.seconds for episode in episodes if episode.recovered]
    return LossStatistics(
        share=float(trace.lost[visible].mean()),
        longest_frames=float(max((episode.frame_count for episode in episodes), default=0)),
        longest_seconds=max((episode.seconds for episode in episodes), default=0.0),
        recovery_seconds=float(np.mean(recoveries)) if recoveries else math.nan,
        unrecovered=float(len(episodes) - len(recoveries)),
    )


def _share(flags: np.typing.NDArray[np.bool_]) -> float:
    return float(flags.mean()) if flags.size else math.nan


def claim_statistics(trace: Trace) -> ClaimStatistics:
    """Summarise the claims of a run."""
    claimed, visible = trace.claimed, trace.visible
    return ClaimStatistics(
        false_tracking=_share(claimed[trace.hidden]),
        silence=_share(~claimed[visible]),
        wrong_claims=_share(trace.off[visible & claimed]),
        useful=_share(trace.useful[visible]),
    )


def nees(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the normalised squared errors, shape (K,).

    Infinite where the covariance is no such thing: singular, or with a negative variance.

    Parameters
    ----------
    errors : FloatArray
        Shape (K, n).
    covariances : FloatArray
        Shape (K, n, n); finite.
    """
    result = np.full(len(errors), np.inf)
    for index, (error, covariance) in enumerate(zip(errors, covariances, strict=True)):
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        if not (sigma > 0.0).all():
            continue
        # px and rad differ by orders of magnitude; correlations do not.
        values, vectors = np.linalg.eigh(covariance / np.outer(sigma, sigma))
        if values[0] > 1e-12:
            result[index] = float(((vectors.T @ (error / sigma)) ** 2 / values).sum())
    return result


def consistency_statistics(trace: Trace) -> ConsistencyStatistics:
    """Compare the errors of the claimed and visible frames with the stated covariances."""
    chosen = trace.claimed & trace.visible & np.isfinite(trace.errors).all(axis=1)
    errors, covariances = trace.errors[chosen], trace.covariances[chosen]
    if not len(errors):
        return ConsistencyStatistics(math.nan, math.nan, np.full(COMPONENTS, np.nan), math.nan)
    squares = nees(errors, covariances)
    return ConsistencyStatistics(
        nees_mean=float(squares.mean()),
        nees_median=float(np.median(squares)),
        inside=(np.abs(errors) <= 2.0 * trace.sigmas[chosen]).mean(axis=0),
        inside_region=float((squares <= REGION_NEES).mean()),
    )


def coverage(traces: Iterable[Trace], nominal: FloatArray) -> FloatArray:
    """Return how often the truth lies inside the central interval of a nominal probability.

    Parameters
    ----------
    traces : iterable of Trace
        Runs whose claimed and visible frames are taken together.
    nominal : FloatArray
        Probabilities, each above 0 and below 1, shape (P,).

    Returns
    -------
    FloatArray
        Shares for d, alpha, w, beta, shape (P, 4); NaN if no frame is claimed.
    """
    ratios = [np.full((0, COMPONENTS), np.nan)]
    for trace in traces:
        chosen = trace.claimed & trace.visible
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios.append(np.abs(trace.errors[chosen]) / trace.sigmas[chosen])
    pooled = np.concatenate(ratios)
    if not len(pooled):
        return np.full((len(nominal), COMPONENTS), np.nan)
    normal = NormalDist()
    limits = np.array([normal.inv_cdf((1.0 + probability) / 2.0) for probability in nominal])
    shares: FloatArray = (pooled[None, :, :] <= limits[:, None, None]).mean(axis=1)
    return shares


def start_statistics(trace: Trace) -> StartStatistics:
    """Tell how the first `START_FRAMES` frames that show a cable went."""
    visible = np.flatnonzero(trace.visible)
    if not len(visible):
        return StartStatistics(None, math.nan, math.nan)
    claimed = trace.claimed[visible]
    found = np.flatnonzero(trace.useful[visible])
    to_right = float(found[0] + 1) if len(found) else math.nan
    if to_right <= START_FRAMES:
        outcome = StartOutcome.RIGHT
    elif claimed[:START_FRAMES].any():
        outcome = StartOutcome.WRONG
    else:
        outcome = StartOutcome.NONE
    visibility = float(trace.visibility[visible[:START_FRAMES]].mean())
    return StartStatistics(outcome, to_right, visibility)


def cable_returns(trace: Trace) -> list[CableReturn]:
    """Return the returns of a cable that was in view before, in order.

    Left out are those after which the cable leaves, or the run ends, before `RETURN_SECONDS` are
    over, because it might still have been found.
    """
    right = trace.useful
    back = trace.visible & (trace.visibility >= CLEARLY_BACK)
    returns = []
    for start in _return_places(trace.hidden, back):
        # Whole nanoseconds, so that a frame after just one second is not lost to rounding.
        elapsed = trace.stamps[start:] - trace.stamps[start]
        count = int(np.searchsorted(elapsed, RETURN_SECONDS * NANOSECONDS, side="right"))
        over = elapsed[-1] >= RETURN_SECONDS * NANOSECONDS
        if not over or trace.hidden[start : start + count].any():
            continue
        found = np.flatnonzero(right[start : start + count])
        seconds = float(elapsed[found[0]] / NANOSECONDS) if len(found) else math.nan
        returns.append(CableReturn(start, seconds))
    return returns


def _return_places(hidden: BoolArray, back: BoolArray) -> list[int]:
    """Return where a cable is clearly back for the first time after it was hidden."""
    places, seen, away = [], False, False
    for place, (is_hidden, is_back) in enumerate(zip(hidden, back, strict=True)):
        away |= seen and bool(is_hidden)
        if is_back and away:
            places.append(place)
            away = False
        seen |= bool(is_back)
    return places


def return_statistics(trace: Trace) -> ReturnStatistics:
    """Summarise the returns of a cable in a run."""
    returns = cable_returns(trace)
    known = [each.seconds for each in returns if not math.isnan(each.seconds)]
    return ReturnStatistics(
        count=float(len(returns)),
        found=len(known) / len(returns) if returns else math.nan,
        seconds=float(np.mean(known)) if known else math.nan,
    )
