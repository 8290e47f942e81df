"""Shape, appearance and usual scores of a target, and their adaptation."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.errors import FrameError
from cable_tracker.target.measure.appearance import (
    Appearance,
    BinMap,
    Bins,
    bins_of,
    choose_bins,
    learn_appearance,
    learn_histograms,
    looked_up,
)
from cable_tracker.target.measure.outline import Outline, find_outline
from cable_tracker.target.measure.region import HueModel, MeasuredFrame, measure_frame, score_poses
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.predicted_density import Births
from cable_tracker.target.model.state import LOG_SCALE, STATE_SIZE
from cable_tracker.target.model.template import (
    LEAST_AREA,
    Template,
    centroid,
    check_area,
    distances_about,
    make_template,
    template_of_mask,
)
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.image_frame import bounding_box
from cable_tracker.tracking.parameter_table import REFERENCE_RATE
from cable_tracker.tracking.rates import share_over_time

REFINEMENT_ROUNDS = 3
"""Iterations in which outline and appearance of a target marked by a box are found in turn."""

BOX_SOFTNESS = 0.15
"""Softness of the ellipse in a box as a prior of shape, in roots of its area."""

BOX_ERROR = 0.15
"""Largest distance of a target's outline beyond the box that marks it, in sides of the box."""

SIZE_TAIL = 4.0
"""Degrees of freedom of the log scale about its running mean."""

RESHAPED_EVERY = 3
"""The template is updated every RESHAPED_EVERY adaptations, with rate 1 - (1 - shape_rate)**k over
the k reference frames since the last time."""

SCORE_RATE = 0.05
"""Share per frame with which the usual score follows: its scatter is from frame to frame."""

LONGEST_LEARNT = 0.2
"""Time that one frame counts for at most where appearance and shape are learnt [s]."""


@dataclass(frozen=True, slots=True)
class UsualScore:
    """The scores of the target while it was in view.

    Attributes
    ----------
    mean, variance : float
        Exponential moving mean and variance of the score.
    """

    mean: float
    variance: float

    def updated(self, score: float, rate: float) -> UsualScore:
        """Return the statistics after one more score; `rate` is its weight."""
        gap = score - self.mean
        variance = (1.0 - rate) * (self.variance + rate * gap * gap)
        return replace(self, mean=self.mean + rate * gap, variance=variance)


FIRST_LIKENESS, FIRST_GREY_LIKENESS = UsualScore(0.8, 0.01), UsualScore(0.95, 0.0025)
"""Prior of the likeness of a target's contour to the target: in colour, and in grey."""


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
    return find_outline(ratios, state, known.template, softness, parameters)


def learn_target(
    frame: WorkingFrame, mask: BoolArray, parameters: TargetParameters, *, is_exact: bool
) -> tuple[KnownTarget, MeasuredFrame]:
    """Learn a target from the frame in which it was marked; return it with the measured frame.

    Its births are about the pose in that frame.

    Parameters
    ----------
    mask : BoolArray
        Marked pixels, shape (H, W).
    is_exact : bool
        Whether the mask is the target's own; else it is that of a box, and is refined.

    Raises
    ------
    FrameError
        The mask is too small, or does not stand out from its surroundings.
    """
    check_area(mask, frame.zoom)
    bins = choose_bins(frame.channels, frame.is_coloured)
    bin_map = bins_of(frame.channels, bins.lookups)
    if not is_exact:
        mask = _refined(mask, frame, bin_map, bins, parameters)
    appearance = learn_appearance(bin_map, mask, bins)
    template = template_of_mask(mask, parameters.template_points, frame.zoom)
    state = _pose_of(mask)
    ratios = looked_up(bin_map, appearance.log_ratios(parameters.ratio_limit))
    plain = HueModel(bin_map, appearance.hue_roots(), 0.0)
    separation = score_poses(
        ratios, state[None], template.inside, template.around, template.size, plain
    )[0]
    if separation < parameters.least_separation:
        raise FrameError(
            "the marked target does not stand out from its surroundings"
            f" (score {separation:.2f}, needs {parameters.least_separation:.2f});"
            " mark it where it does"
        )
    measured = measure_frame(frame, appearance, parameters)
    known = KnownTarget(
        template,
        appearance,
        _first_usual_score(state, measured, template, parameters),
        first_likeness(frame),
        0.0,
        Births(state, 0.0, frame.shape),
    )
    return known, measured


def _pose_of(mask: BoolArray) -> FloatArray:
    """Return the pose of a marked mask (H, W): upright, of scale 1, at rest, shape (6,)."""
    state = np.zeros(STATE_SIZE)
    state[:2] = centroid(mask)
    return state


def _refined(
    mask: BoolArray,
    frame: WorkingFrame,
    bin_map: BinMap,
    bins: Bins,
    parameters: TargetParameters,
) -> BoolArray:
    """Return the target's own pixels in the mask of a box: outline and appearance in turn."""
    marked = template_of_mask(mask, parameters.template_points, frame.zoom)
    state = _pose_of(mask)
    allowed = _widened(mask)
    for _ in range(REFINEMENT_ROUNDS):
        appearance = learn_appearance(bin_map, mask, bins)
        ratios = looked_up(bin_map, appearance.log_ratios(parameters.ratio_limit))
        outline = find_outline(ratios, state, marked, BOX_SOFTNESS, parameters)
        if outline is None:
            break
        found = outline.in_picture(frame.shape) & allowed
        if found.sum() < max(LEAST_AREA, 0.15 * mask.sum()):
            break
        mask = found
    return mask


def _widened(mask: BoolArray) -> BoolArray:
    """Return the box around a mask that is not empty, with a margin of `BOX_ERROR`, as a mask."""
    box = bounding_box(mask)
    assert box is not None
    left, top, right, bottom = box
    across = int(BOX_ERROR * (right - left)) + 1
    down = int(BOX_ERROR * (bottom - top)) + 1
    widened = np.zeros_like(mask)
    widened[max(top - down, 0) : bottom + down, max(left - across, 0) : right + across] = True
    return widened


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
