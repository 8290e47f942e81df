"""Everything that is measured about one run: names, labels, units and values of the metrics."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, true_runs
from cable_tracker.cable.model.state import POSE_COMPONENTS
from cable_tracker.evaluation.consistency import REGION_NEES, nees
from cable_tracker.evaluation.errors import error_statistics
from cable_tracker.evaluation.sample_statistics import mean, median
from cable_tracker.evaluation.trace import Trace
from cable_tracker.stamps import NANOSECONDS

CLEARLY_BACK = 0.3
"""A cable that was out of view is back when so large a share of its borders can be seen."""

RETURN_SECONDS = 1.0
"""Time after the return within which a right claim counts as found again [s]."""

START_FRAMES = 30
"""Number of frames that show the cable within which a right claim makes a start succeed."""


def run_metrics(trace: Trace, *, started_at_random: bool) -> dict[str, float]:
    """Measure a run.

    Parameters
    ----------
    trace : Trace
        At least one frame.
    started_at_random : bool
        Whether the method had to find the cable by itself; only then its start is judged.

    Returns
    -------
    dict of str to float
        Values by the names of `METRIC_TABLE`, in its units; NaN where one is not defined.
    """
    visible = trace.visible
    return {
        "frames": float(len(trace)),
        "visible": float(visible.sum()),
        **_claims(trace),
        **_losses(trace),
        **(_start(trace) if started_at_random else _NO_START),
        **_returns(trace),
        # Of all visible frames, also those in which the mean is off or not claimed.
        **_errors("", trace.errors[visible]),
        # Of the visible frames in which the mean is not off, claimed or not.
        **_errors("held_", trace.errors[visible & ~trace.off]),
        **_consistency(trace),
        "ms": float(np.median(trace.ms)),
        "ms_p95": float(np.percentile(trace.ms, 95)),
    }


def _claims(trace: Trace) -> dict[str, float]:
    """Tell whether the method says rightly that there is a cable."""
    claimed, visible = trace.claimed, trace.visible
    return {
        "useful": 100.0 * mean(trace.useful[visible]),
        "false_tracking": 100.0 * mean(claimed[trace.hidden]),
        "silence": 100.0 * mean(~claimed[visible]),
        # Of the claims, not of the frames.
        "wrong_claims": 100.0 * mean(trace.off[visible & claimed]),
    }


def _losses(trace: Trace) -> dict[str, float]:
    """Return the metrics of losses, silence included, and of recoveries."""
    visible = trace.visible
    losses = loss_episodes(trace)
    recoveries = [loss.seconds for loss in losses if loss.recovered]
    values = {
        "lost": 100.0 * mean(trace.lost[visible]),
        "longest_loss_frames": float(max((loss.frame_count for loss in losses), default=0)),
        "longest_loss": max((loss.seconds for loss in losses), default=0.0),
        "recovery": mean(recoveries),
        "unrecovered": float(len(losses) - len(recoveries)),
    }
    return values if visible.any() else dict.fromkeys(values, math.nan)


@dataclass(frozen=True, slots=True)
class LossEpisode:
    """A stretch of visible frames in which the cable was not claimed rightly.

    Attributes
    ----------
    frame_count : int
        Number of its frames.
    seconds : float
        Time from its first frame to the next frame on the cable, or to the end [s].
    recovered : bool
        Whether the method found back while the cable remained visible.
    """

    frame_count: int
    seconds: float
    recovered: bool


def loss_episodes(trace: Trace) -> list[LossEpisode]:
    """Return the losses of a run, in order.

    Frames that are not judged do not interrupt a loss; frames without a cable end it, and so does
    the end of a recording of a list.
    """
    parts = (trace.part(start, stop) for start, stop in trace.recordings)
    return [episode for part in parts for episode in _episodes_of_recording(part)]


def _episodes_of_recording(trace: Trace) -> list[LossEpisode]:
    judged = np.flatnonzero(trace.visible | trace.hidden)
    lost, visible = trace.lost[judged], trace.visible[judged]
    stamps = trace.stamps[judged] / NANOSECONDS
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    episodes = []
    for start, end in true_runs(lost):
        recovered = end < len(judged) and bool(visible[end])
        until = stamps[end] if recovered else stamps[end - 1] + period
        episodes.append(LossEpisode(end - start, float(until - stamps[start]), recovered))
    return episodes


def _start(trace: Trace) -> dict[str, float]:
    """Return the metrics of a start without knowledge of the cable."""
    start = start_statistics(trace)
    known = start.outcome is not None
    return {
        "start_right": 100.0 * (start.outcome is StartOutcome.RIGHT) if known else math.nan,
        "start_wrong": 100.0 * (start.outcome is StartOutcome.WRONG) if known else math.nan,
        "frames_to_right": start.frames_to_right,
    }


_NO_START = dict.fromkeys(("start_right", "start_wrong", "frames_to_right"), math.nan)


def _returns(trace: Trace) -> dict[str, float]:
    """Return how often and how soon a cable that came back into view was found again."""
    times = return_times(trace)
    known = [seconds for seconds in times if not math.isnan(seconds)]
    return {
        "returns": float(len(times)),
        "found_again": 100.0 * (len(known) / len(times)) if times else math.nan,
        "time_to_find": mean(known),
    }


def return_times(trace: Trace) -> list[float]:
    """Return how soon the cable was claimed at each of its returns, in order [s].

    Times are counted from the first frame with a visibility of `CLEARLY_BACK` to the first right
    claim: 0 if it was claimed before, NaN if it was not in `RETURN_SECONDS`. Left out are returns
    after which the cable leaves, or the recording ends, before `RETURN_SECONDS` are over, because
    it might still have been found.
    """
    parts = (trace.part(start, stop) for start, stop in trace.recordings)
    return [seconds for part in parts for seconds in _return_times_of_recording(part)]


def _return_times_of_recording(trace: Trace) -> list[float]:
    right = trace.useful
    back = trace.visible & (trace.visibility >= CLEARLY_BACK)
    times = []
    for start in _return_places(trace.hidden, back):
        # Whole nanoseconds, so that a frame after just one second is not lost to rounding.
        elapsed = trace.stamps[start:] - trace.stamps[start]
        count = int(np.searchsorted(elapsed, RETURN_SECONDS * NANOSECONDS, side="right"))
        over = elapsed[-1] >= RETURN_SECONDS * NANOSECONDS
        if not over or trace.hidden[start : start + count].any():
            continue
        found = np.flatnonzero(right[start : start + count])
        times.append(float(elapsed[found[0]] / NANOSECONDS) if len(found) else math.nan)
    return times


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


def _errors(prefix: str, errors: FloatArray) -> dict[str, float]:
    """Summarise errors of d, alpha, w, beta, shape (K, 4) [px, rad]."""
    statistics = error_statistics(errors)
    measures = {
        "bias": statistics.bias,
        "rmse": statistics.rmse,
        "median": statistics.median,
        "p95": statistics.percentile_95,
    }
    return {
        f"{prefix}{name}_{axis}": float(value) * factor
        for name, values in measures.items()
        for value, (axis, _, _, factor) in zip(values, POSE_COMPONENTS, strict=True)
    }


def _consistency(trace: Trace) -> dict[str, float]:
    """Tell whether errors are as large as the covariance says, over claimed and visible frames.

    The mean NEES of (d, alpha, w, beta) is 4 and the median 3.36 if the covariance is right, larger
    if it is too small.
    """
    chosen = trace.claimed & trace.visible & np.isfinite(trace.errors).all(axis=1)
    errors = trace.errors[chosen]
    squares = nees(errors, trace.covariances[chosen])
    inside = np.abs(errors) <= 2.0 * trace.sigmas[chosen]
    return {
        "nees_mean": mean(squares),
        "nees_median": median(squares),
        **{
            f"inside_2_sigma_{axis}": 100.0 * mean(flags)
            for flags, (axis, *_) in zip(inside.T, POSE_COMPONENTS, strict=True)
        },
        "inside_region": 100.0 * mean(squares <= REGION_NEES),
    }


class StartOutcome(str, Enum):
    """How a start without knowledge of the cable went."""

    RIGHT = "right"
    """The cable was claimed, and rightly, within `START_FRAMES` frames."""

    WRONG = "wrong"
    """Start with claims in time, but only of something else: a wrong lock."""

    NONE = "none"
    """Start without a claim in time."""


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


def start_statistics(trace: Trace) -> StartStatistics:
    """Return the statistics of the first `START_FRAMES` frames that show a cable."""
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


@dataclass(frozen=True, slots=True)
class MetricSpec:
    """One number about a run, of which `run_metrics` makes the value.

    Attributes
    ----------
    name : str
        Column in tables for machines.
    label : str
        For people.
    unit : str
        Unit of the value; empty for pure numbers.
    """

    name: str
    label: str
    unit: str = ""

    @property
    def heading(self) -> str:
        """Name and unit, for a table's column."""
        return self._with_unit(self.name)

    @property
    def title(self) -> str:
        """Label and unit, for a table's column or a table of its own."""
        return self._with_unit(self.label)

    def _with_unit(self, text: str) -> str:
        return f"{text} [{self.unit}]" if self.unit else text


def _error_specs(prefix: str, words: str) -> Iterable[MetricSpec]:
    measures = {"bias": "bias", "rmse": "RMSE", "median": "median", "p95": "95th percentile"}
    for name, label in measures.items():
        for axis, symbol, unit, _ in POSE_COMPONENTS:
            yield MetricSpec(f"{prefix}{name}_{axis}", f"{label} of {symbol}{words}", unit)


METRIC_TABLE: tuple[MetricSpec, ...] = (
    MetricSpec("frames", "frames"),
    MetricSpec("visible", "frames with a visible cable"),
    MetricSpec("useful", "useful frames", "%"),
    MetricSpec("lost", "frames lost", "%"),
    MetricSpec("longest_loss_frames", "longest loss", "frames"),
    MetricSpec("longest_loss", "longest loss", "s"),
    MetricSpec("recovery", "time to recover", "s"),
    MetricSpec("unrecovered", "losses never recovered"),
    MetricSpec("false_tracking", "false tracking", "%"),
    MetricSpec("silence", "silence", "%"),
    MetricSpec("wrong_claims", "wrong claims, of all claims", "%"),
    MetricSpec("start_right", "right start", "%"),
    MetricSpec("start_wrong", "wrong lock", "%"),
    MetricSpec("frames_to_right", "frames until the cable is claimed"),
    MetricSpec("returns", "returns of the cable"),
    MetricSpec("found_again", "found again", "%"),
    MetricSpec("time_to_find", "time to find it again", "s"),
    *_error_specs("", ""),
    *_error_specs("held_", " while held"),
    MetricSpec("nees_mean", "mean NEES"),
    MetricSpec("nees_median", "median NEES"),
    *(
        MetricSpec(f"inside_2_sigma_{axis}", f"truth of {symbol} inside 2σ", "%")
        for axis, symbol, *_ in POSE_COMPONENTS
    ),
    MetricSpec("inside_region", "truth inside the 95 % region", "%"),
    MetricSpec("ms", "processor time per frame", "ms"),
    MetricSpec("ms_p95", "95th percentile of the processor time per frame", "ms"),
)
"""Metrics of a run, in the order of the tables."""

METRICS_BY_NAME: Mapping[str, MetricSpec] = {spec.name: spec for spec in METRIC_TABLE}
