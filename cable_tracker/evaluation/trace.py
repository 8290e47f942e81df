"""Outputs of a method for each frame of a run, beside the truth, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import compress, pairwise

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.geometry import wrapped_estimate
from cable_tracker.cable.model.state import POSE_SIZE, WIDTH, CableState
from cable_tracker.evaluation.errors import forgiven_distances, is_off_cable
from cable_tracker.sequences.labels.sequence_file import APART
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.status import TrackingStatus

UNKNOWN_VISIBILITY = float("nan")
"""Visibility of a frame that has no label; it is not judged."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameOutcome:
    """One frame, what is true of it, and what a method said.

    Attributes
    ----------
    index : int
        Number of the frame in its sequence.
    truth : CableState or None
        True state of the cable; None if there is none, or it is unknown.
    visibility : float
        Share of the borders that can be seen, 0 to 1; NaN if unknown.
    estimate : CableEstimate
        Estimate of the method.
    ms : float
        Time that it took [ms].
    """

    index: int
    truth: CableState | None
    visibility: float
    estimate: CableEstimate
    ms: float


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A run of T frames. NaN stands where there is no value.

    Attributes
    ----------
    frames : IndexArray
        Numbers of the frames in their sequence, shape (T,).
    stamps : IndexArray
        Times of the frames, shape (T,) [ns].
    visibility : FloatArray
        Share of the borders that can be seen, shape (T,); NaN if unknown.
    truths : FloatArray
        d, alpha, w, beta, shape (T, 4) [px, rad].
    estimates : FloatArray
        The same of the method's mean, whether it was claimed or not, shape (T, 4); written on the
        same side of the wrap as the truth.
    covariances : FloatArray
        Covariances of d, alpha, w, beta in that chart, shape (T, 4, 4).
    statuses : tuple of TrackingStatus
        Length T.
    ms : FloatArray
        Time that the method took, shape (T,) [ms].
    image_widths : IndexArray
        Widths of the frames, shape (T,) [px]; they differ where a list holds several recordings.
    """

    frames: IndexArray
    stamps: IndexArray
    visibility: FloatArray
    truths: FloatArray
    estimates: FloatArray
    covariances: FloatArray
    statuses: tuple[TrackingStatus, ...]
    ms: FloatArray
    image_widths: IndexArray

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def recordings(self) -> list[tuple[int, int]]:
        """First frame and last + 1 of each recording of a list, counted from the run's first."""
        begins = np.flatnonzero(np.diff(self.stamps) >= APART // 2) + 1
        return list(pairwise([0, *begins.tolist(), len(self)]))

    @property
    def seconds(self) -> float:
        """Duration from first to last frame, over all recordings, without what is between [s]."""
        spans = (self.stamps[stop - 1] - self.stamps[start] for start, stop in self.recordings)
        return float(sum(spans)) / NANOSECONDS

    @property
    def claimed(self) -> BoolArray:
        """Whether the method claims a cable, shape (T,)."""
        return np.array([status is TrackingStatus.TRACKING for status in self.statuses], bool)

    @property
    def visible(self) -> BoolArray:
        """Whether a cable is visible, and its true state known, shape (T,)."""
        known = np.isfinite(self.truths).all(axis=1)
        return np.asarray(known & (self.visibility > 0.0))

    @property
    def hidden(self) -> BoolArray:
        """Whether it is known that no cable is visible, shape (T,)."""
        return np.asarray(self.visibility == 0.0)

    @property
    def errors(self) -> FloatArray:
        """Estimate minus truth, shape (T, 4) [px, rad]."""
        return self.estimates - self.truths

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviations that the method states, shape (T, 4) [px, rad]."""
        variances = np.diagonal(self.covariances, axis1=1, axis2=2)
        return np.sqrt(np.maximum(variances, 0.0))

    @property
    def useful(self) -> BoolArray:
        """Whether a visible cable is claimed, and rightly, shape (T,)."""
        return np.asarray(self.visible & self.claimed & ~self.off)

    @property
    def lost(self) -> BoolArray:
        """Whether a visible cable is not claimed, or wrongly, shape (T,): silence is loss."""
        return np.asarray(self.visible & ~self.useful)

    @property
    def off(self) -> BoolArray:
        """Whether a visible cable is missed, as `is_off_cable` has it, shape (T,).

        The mean counts whether or not it is claimed.
        """
        widths = self.truths[:, WIDTH]
        return self.visible & is_off_cable(
            self.errors, widths, forgiven=forgiven_distances(self.image_widths)
        )

    def part(self, start: int, stop: int) -> Trace:
        """Return the frames from `start` to before `stop`, counted from the run's first."""
        places = np.arange(len(self))
        return self.where((start <= places) & (places < stop))

    def where(self, mask: BoolArray) -> Trace:
        """Return only the frames in which a mask of shape (T,) is true."""
        return Trace(
            frames=self.frames[mask],
            stamps=self.stamps[mask],
            visibility=self.visibility[mask],
            truths=self.truths[mask],
            estimates=self.estimates[mask],
            covariances=self.covariances[mask],
            statuses=tuple(compress(self.statuses, mask)),
            ms=self.ms[mask],
            image_widths=self.image_widths[mask],
        )


def trace_of(outcomes: Sequence[FrameOutcome]) -> Trace:
    """Put the outcomes of a run into arrays; at least one."""
    pairs = [_in_chart(outcome) for outcome in outcomes]
    return Trace(
        frames=np.array([outcome.index for outcome in outcomes], np.int64),
        stamps=np.array([outcome.estimate.stamp for outcome in outcomes], np.int64),
        visibility=np.array([outcome.visibility for outcome in outcomes], np.float64),
        truths=np.array([_truth(outcome) for outcome in outcomes]),
        estimates=np.array([estimate for estimate, _ in pairs]),
        covariances=np.array([covariance for _, covariance in pairs]),
        statuses=tuple(outcome.estimate.status for outcome in outcomes),
        ms=np.array([outcome.ms for outcome in outcomes], np.float64),
        image_widths=np.array([outcome.estimate.image_size[0] for outcome in outcomes], np.int64),
    )


def _truth(outcome: FrameOutcome) -> FloatArray:
    if outcome.truth is None:
        return np.full(POSE_SIZE, np.nan)
    return outcome.truth.to_array()[:POSE_SIZE]


def _in_chart(outcome: FrameOutcome) -> tuple[FloatArray, FloatArray]:
    """Return estimate (4,) and covariance (4, 4), on the same side of the wrap as the truth."""
    values = outcome.estimate.state.to_array()
    covariance = outcome.estimate.covariance
    if outcome.truth is None or not np.isfinite(values).all():
        return values[:POSE_SIZE], covariance[:POSE_SIZE, :POSE_SIZE]
    chart, covariance = wrapped_estimate(values, covariance, outcome.truth.angle)
    return chart[:POSE_SIZE], covariance[:POSE_SIZE, :POSE_SIZE]
