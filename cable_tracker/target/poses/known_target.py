"""Shape, appearance and usual scores of a target, and their adaptation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.target.measure.appearance import (
    Appearance,
    learn_appearance,
    learn_histograms,
)
from cable_tracker.target.measure.clutter import UsualScore
from cable_tracker.target.measure.features import bins_of, choose_bins
from cable_tracker.target.measure.first_look import FirstLook
from cable_tracker.target.measure.outline import Outline, contour_settings, find_outline
from cable_tracker.target.measure.region import MeasuredFrame, measure_frame
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.births import Births
from cable_tracker.target.model.state import LOG_SCALE
from cable_tracker.target.model.template import Template, centroid, distances_about, make_template
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import REFERENCE_RATE
from cable_tracker.tracking.rates import share_over_time

FIRST_LIKENESS, FIRST_GREY_LIKENESS = UsualScore(0.8, 0.01), UsualScore(0.95, 0.0025)
"""Prior of the likeness of a target's contour to the target: in colour, and in grey."""

SIZE_TAIL = 4.0
"""Degrees of freedom of the log scale about its running mean."""

RESHAPED_EVERY = 3
"""The template is updated every RESHAPED_EVERY adaptations, with rate 1 - (1 - shape_rate)**k over
the k reference frames since the last time."""

SCORE_RATE = 0.05
"""Share per frame with which the usual score follows: its scatter is from frame to frame."""

LONGEST_LEARNT = 0.2
"""Time that one frame counts for at most where appearance and shape are learnt [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class KnownTarget:
    """Shape, appearance, size and usual scores of a target.

    Attributes
    ----------
    template : Template
        Shape.
    appearance : Appearance
        Colours or greys, and texture.
    usual : UsualScore
        Scores of its region.
    usual_likeness : UsualScore
        Mean and variance of the likeness of its contour to the target.
    usual_log_scale : float
        Running mean of the log scale.
    births : Births
        Density of the places where it comes into view.
    adaptations : int
        Number of frames that shape and appearance were adapted to.
    unshaped : float
        Reference frames since the shape last followed; at the beginning as if it were due.
    """

    template: Template
    appearance: Appearance
    usual: UsualScore
    usual_likeness: UsualScore
    usual_log_scale: float
    births: Births
    adaptations: int = 0
    unshaped: float = RESHAPED_EVERY - 1.0

    @property
    def is_coloured(self) -> bool:
        """Whether it has been learnt from frames in colour."""
        return self.appearance.bins.shape[2] > 1

    def size_at(self, state: FloatArray) -> float:
        """Return the root of its area in a pose (6,) [px]."""
        return self.template.size * math.exp(state[LOG_SCALE])

    def log_size_factor(self, states: FloatArray, spread: float) -> FloatArray:
        """Return the log-densities of the scales of poses, relative to that of the usual one, (N,).

        Parameters
        ----------
        states : FloatArray
            Poses, shape (N, 6).
        spread : float
            Spread of the log scale, while the target is in view.
        """
        # The longer it has not been seen, the less its size is known.
        widened = spread * (1.0 + self.births.seconds)
        gaps = (states[:, LOG_SCALE] - self.usual_log_scale) / widened
        factors: FloatArray = -0.5 * (SIZE_TAIL + 1.0) * np.log1p(gaps**2 / SIZE_TAIL)
        return factors

    def with_last_pose(self, state: FloatArray) -> KnownTarget:
        """Return the target with a pose (6,) in which it was surely in view."""
        return replace(self, births=replace(self.births, last=state.copy(), seconds=0.0))

    def with_size(self, state: FloatArray, share: float) -> KnownTarget:
        """Return the target with its usual size moved by a share towards that of a pose (6,)."""
        gap = float(state[LOG_SCALE]) - self.usual_log_scale
        return replace(self, usual_log_scale=self.usual_log_scale + share * gap)


@dataclass(frozen=True, slots=True, eq=False)
class ContourHistograms:
    """Histograms within and around the contour of a frame.

    Attributes
    ----------
    target, around : FloatArray
        Histograms within and around it.
    likeness : float
        Likeness of `target` to the histogram of the known target, 0 to 1.
    """

    target: FloatArray
    around: FloatArray
    likeness: float


def first_likeness(frame: WorkingFrame) -> UsualScore:
    """Return the prior of the likeness, before any contour was measured."""
    return FIRST_LIKENESS if frame.is_coloured else FIRST_GREY_LIKENESS


def outline_at(
    state: FloatArray,
    ratios: NDArray[np.float32],
    frame: WorkingFrame,
    known: KnownTarget,
    parameters: TargetParameters,
) -> Outline | None:
    """Return the outline of a target about a pose (6,), see `find_outline`.

    Parameters
    ----------
    ratios : array
        Log-ratios of the frame's pixels, float32, shape (H, W).
    """
    softness = parameters.prior_softness if frame.is_coloured else parameters.grey_prior_softness
    settings = contour_settings(parameters)
    return find_outline(ratios, state, known.template, softness, settings)


def first_known(
    first: FirstLook, measured: MeasuredFrame, parameters: TargetParameters
) -> KnownTarget:
    """Return a target as known after the frame in which it was marked."""
    frame = measured.frame
    return KnownTarget(
        first.template,
        first.appearance,
        _first_usual_score(first.state, measured, first.template, parameters),
        first_likeness(frame),
        0.0,
        Births(first.state, 0.0, frame.shape),
    )


def relearnt(
    known: KnownTarget, state: FloatArray, frame: WorkingFrame, parameters: TargetParameters
) -> KnownTarget:
    """Learn the appearance anew where the target is expected: colour came or went.

    Nothing is learnt where the greys there are not the target's: colour also goes with a target
    that was all that had any, and comes with what hides one.
    """
    nothing_shown = np.zeros(frame.shape, np.float32)
    expected = outline_at(state, nothing_shown, frame, known, parameters)
    if expected is None:
        return known
    mask = expected.in_picture(frame.shape)
    if not known.appearance.resembles_target(frame.channels[mask, 0]):
        return known
    bins = choose_bins(frame.channels, frame.is_coloured)
    bin_map = bins_of(frame.channels, bins.lookups)
    appearance = learn_appearance(bin_map, mask, bins)
    measured = measure_frame(frame, appearance, parameters)
    usual = _first_usual_score(state, measured, known.template, parameters)
    return replace(known, appearance=appearance, usual=usual, usual_likeness=first_likeness(frame))


def _first_usual_score(
    state: FloatArray, measured: MeasuredFrame, template: Template, parameters: TargetParameters
) -> UsualScore:
    """Return the usual score from that in a pose (6,) of a single frame."""
    score = float(measured.scores(state[None], template)[0])
    return UsualScore(score, (parameters.score_spread * score) ** 2)


def contour_histograms(
    outline: Outline | None,
    measured: MeasuredFrame,
    known: KnownTarget,
    parameters: TargetParameters,
) -> ContourHistograms | None:
    """Return the histograms of a frame within and around a contour; None without one."""
    if outline is None or outline.area == 0:
        return None
    mask = outline.in_picture(measured.frame.shape)
    appearance = known.appearance
    target, around = learn_histograms(measured.bins, mask, appearance.bins.count)
    likeness = appearance.likeness(target, parameters.first_look_share)
    return ContourHistograms(target, around, likeness)


def adapted_to_contour(
    known: KnownTarget,
    outline: Outline,
    shown: ContourHistograms,
    parameters: TargetParameters,
    *,
    dt: float,
    angle: float,
    score: float,
) -> KnownTarget:
    """Adapt shape, appearance and usual scores to the contour of a frame.

    Parameters
    ----------
    known : KnownTarget
        Target as known before the frame.
    shown : ContourHistograms
        Histograms within and around it.
    dt : float
        Time since the frame before [s].
    angle : float
        Angle of the target [rad].
    score : float
        Score of its region.
    """
    # After a pause one frame does not outweigh all before.
    learnt = min(dt, LONGEST_LEARNT)
    appearance = known.appearance.adapted(
        shown.target,
        shown.around,
        share_over_time(parameters.appearance_rate_of_target, learnt),
        share_over_time(parameters.appearance_rate_around, learnt),
    )
    template, unshaped = known.template, known.unshaped + learnt * REFERENCE_RATE
    # Contours about poses that are too short would shorten a bar further.
    follows = parameters.shape_rate > 0.0 and not known.template.is_bar
    if follows and known.adaptations % RESHAPED_EVERY == 0:
        template = _reshaped(known.template, outline, angle, unshaped, parameters)
        unshaped = 0.0
    return replace(
        known,
        appearance=appearance,
        template=template,
        usual=known.usual.updated(score, SCORE_RATE),
        usual_likeness=known.usual_likeness.updated(shown.likeness, SCORE_RATE),
        adaptations=known.adaptations + 1,
        unshaped=unshaped,
    )


def _reshaped(
    template: Template, outline: Outline, angle: float, frames: float, parameters: TargetParameters
) -> Template:
    """Return the template moved towards the contour, both about their centroids.

    As far as in a number of reference frames.
    """
    distances = distances_about(
        outline.mask,
        centroid(outline.mask),
        math.sqrt(outline.area),
        angle,
        len(template.distances),
    )
    share = 1.0 - (1.0 - parameters.shape_rate) ** frames
    blended = (1.0 - share) * template.distances + share * distances
    return make_template(blended.astype(np.float32), template.size, parameters.template_points)
