"""How much of a visible cable a run lost, and how soon it recovered."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import true_runs
from cable_tracker.evaluation.sample_statistics import mean
from cable_tracker.evaluation.trace import Trace
from cable_tracker.stamps import NANOSECONDS


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
        Duration of the longest loss [s].
    recovery_seconds : float
        Mean duration of the losses that were recovered from [s]; NaN if there was none.
    unrecovered : float
        Number of losses that lasted until the cable left or the recording ended.
    """

    share: float
    longest_frames: float
    longest_seconds: float
    recovery_seconds: float
    unrecovered: float


def loss_episodes(trace: Trace) -> list[LossEpisode]:
    """Return the losses of a run, in order.

    Frames that are not judged do not interrupt a loss; frames without a cable end it, and so does
    the end of a recording of a list.
    """
    return [
        episode
        for start, stop in trace.recordings
        for episode in _episodes_of_recording(trace.part(start, stop), start)
    ]


def _episodes_of_recording(trace: Trace, first: int) -> list[LossEpisode]:
    """Return the losses of one recording, whose first frame is the run's frame `first`."""
    judged = np.flatnonzero(trace.visible | trace.hidden)
    lost, visible = trace.lost[judged], trace.visible[judged]
    stamps = trace.stamps[judged] / NANOSECONDS
    period = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    episodes = []
    for start, end in true_runs(lost):
        recovered = end < len(judged) and bool(visible[end])
        until = stamps[end] if recovered else stamps[end - 1] + period
        episodes.append(
            LossEpisode(
                first + int(judged[start]), end - start, float(until - stamps[start]), recovered
            )
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
        recovery_seconds=mean(recoveries),
        unrecovered=float(len(episodes) - len(recoveries)),
    )
