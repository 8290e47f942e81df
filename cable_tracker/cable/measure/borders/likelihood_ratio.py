"""The learnt observation model: how much likelier a frame is with a cable than without.

Where each border crosses the scan lines, the response across it and its slope are looked up in a
table of log-likelihood ratios, border against background. A border that is overgrown at a point
costs a bounded amount there. Neighbouring points are not independent, so the sum is tempered.

How strong the borders of a cable are is a hidden variable of four classes, summed over: the two
borders of a cable are about as strong as each other, and nothing is said of how strong that is.

A cable may be bright in some stretches and dark in others, see `stretches`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, IndexArray
from cable_tracker.cable.measure.borders.border_points import (
    border_line,
    room_for_crossings,
)
from cable_tracker.cable.measure.borders.response_table import (
    CLASSES,
    ResponseTable,
    load_table,
)
from cable_tracker.cable.measure.borders.stretches import (
    STRETCHES,
    stretch_axis,
    stretch_scale,
    sum_border,
    sum_stretches,
)
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.measure.scanned_gradients import ScanInputs
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.cable.model.state import POSE_SIZE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled, compiled_inside, compiled_part
from cable_tracker.particle_filter.existence import probability_of

BRIGHT, DARK = 0, 1
"""Columns of what is said of cables that are brighter, and darker, than the bottom."""

TEMPERED_SPACING = 5.0
"""Spacing of the points that the parameter `tempering` is given for [px at the reference width]."""

STRENGTH_STEP = 6.0
"""What it costs that the strengths of the two borders of a cable are one class apart [nats]."""

_APART = np.abs(np.subtract.outer(np.arange(CLASSES), np.arange(CLASSES)))
JOINT_STRENGTHS = np.exp(-STRENGTH_STEP * _APART) / np.exp(-STRENGTH_STEP * _APART).sum()
"""Prior probability of the classes of the left and the right border, shape (4, 4)."""


ONE_POINT = 1.0
"""Expected length of borders whose parts beyond the edge are neither paid for nor counted."""


class PolarityPrior(NamedTuple):
    """Logarithms of how likely a cable is to be brighter than the bottom, and darker."""

    log_bright: float
    log_dark: float


def polarity_prior(p_bright: float) -> PolarityPrior:
    """Return the prior for a probability of bright ones, above 0 and below 1."""
    return PolarityPrior(math.log(p_bright), math.log1p(-p_bright))


EITHER = polarity_prior(0.5)
"""Bright and dark cables are as likely."""


@compiled_inside
def marginal_log_ratio(polarity: PolarityPrior, bright: float, dark: float) -> float:
    """Return the log-likelihood ratio of a cable whose polarity is not known.

    `bright` and `dark` are those of a bright and of a dark cable.
    """
    first, second = polarity.log_bright + bright, polarity.log_dark + dark
    higher, less = max(first, second), min(first, second)
    return higher + math.log1p(math.exp(less - higher))


@compiled_part
def marginal_log_ratios(log_ratios: FloatArray, polarity: PolarityPrior) -> FloatArray:
    """Return the log-likelihood ratios (N,) of cables whose polarity is not known.

    `log_ratios` are those of bright and of dark cables, shape (N, 2).
    """
    result = np.empty(len(log_ratios))
    for row in range(len(log_ratios)):
        result[row] = marginal_log_ratio(polarity, log_ratios[row, BRIGHT], log_ratios[row, DARK])
    return result


@compiled_inside
def bright_share(polarity: PolarityPrior, bright: float, dark: float) -> float:
    """Return the posterior probability that a cable is a bright one; see `marginal_log_ratio`."""
    return probability_of(polarity.log_bright - polarity.log_dark + bright - dark)


class CableMeasures(NamedTuple):
    """What a frame shows of N cables, by columns `BRIGHT` and `DARK` where polarity matters.

    Attributes
    ----------
    log_ratios : FloatArray
        Tempered log-likelihood ratio, cable against no cable, shape (N, 2) [nats].
    visible_lengths : FloatArray
        Length inside the image of the shorter border [distances of the scan lines], shape (N,).
    border_means : FloatArray
        Mean log-likelihood ratio per point of the left and of the right border, each alone, not
        tempered, shape (N, 2, 2): cable, polarity, border [nats].
    reversed : IndexArray
        Stretches of a bright and of a dark cable that are of the other polarity, see `stretches`,
        shape (N, 2): bit k is stretch k.
    covered : IndexArray
        Those of a covered end without which the cable is looked at, see `stretches`, likewise.
    """

    log_ratios: FloatArray
    visible_lengths: FloatArray
    border_means: FloatArray
    reversed: IndexArray
    covered: IndexArray


@compiled_part
def allocate_measures(count: int) -> CableMeasures:
    """Return uninitialised arrays for N cables."""
    return CableMeasures(
        np.empty((count, 2)),
        np.empty(count),
        np.empty((count, 2, 2)),
        np.empty((count, 2), np.int64),
        np.empty((count, 2), np.int64),
    )


class RatioModel(NamedTuple):
    """What turns measures into log-likelihood ratios, for frames of one size.

    Attributes
    ----------
    ratios : Float32Array
        Ratios of a point for bright and for dark cables, see `ResponseTable.ratios`.
    tempering : float
        Power of one point's ratio.
    missing : FloatArray
        Log-likelihood ratio of a point that a border lacks, by class of strength, shape (4,).
    reversal_cost : float
        Cost of a stretch of the other polarity [nats].
    covered_cost : float
        Cost of a covered end [nats].
    """

    ratios: Float32Array
    tempering: float
    missing: FloatArray
    reversal_cost: float
    covered_cost: float


class BorderLikelihoodRatio:
    """Likelihood of a frame given a cable over that given none.

    Parameters
    ----------
    parameters : TrackerParameters
        `tempering`, `missing_cost`, `reversal_cost`, `covered_cost` and `response_table`.
    table : ResponseTable or None
        Ratios of single points; None: those of the file that the parameters name.

    Raises
    ------
    ParameterError
        The file cannot be read.
    """

    def __init__(self, parameters: TrackerParameters, table: ResponseTable | None = None) -> None:
        self._parameters = parameters
        self._table = table if table is not None else load_table(parameters.response_table)

    def log_likelihoods(self, states: FloatArray, image: WorkingImage) -> FloatArray:
        """Return the log-likelihood ratio of each cable, either polarity as likely; shape (N,)."""
        return _marginal_log_ratios(self.measure(states, image).log_ratios, EITHER)

    def measure(self, states: FloatArray, image: WorkingImage) -> CableMeasures:
        """Measure cables, shape (N, 4) or more columns.

        Raises
        ------
        ValueError
            There are fewer columns: compiled code would read beyond them.
        """
        if states.ndim != 2 or states.shape[1] < POSE_SIZE:
            raise ValueError(f"cables must have shape (N, >= {POSE_SIZE}), not {states.shape}")
        rows = np.array(states, np.float64, order="C")
        return _measure_all(rows, image.scan, self.model_for(image))

    def evidence(self, state: FloatArray, image: WorkingImage) -> float:
        """Return the mean log-likelihood ratio per point of a cable's weaker border; state (8,)."""
        return float(self.measure(state[None, :], image).border_means[0].min(axis=1).max())

    def model_for(self, image: WorkingImage) -> RatioModel:
        """Return the model for a frame."""
        parameters = self._parameters
        # The parameter is for points `TEMPERED_SPACING` apart; independent points have power 1.
        power = parameters.tempering * image.line_spacing / image.scale / TEMPERED_SPACING
        return RatioModel(
            self._table.ratios,
            min(power, 1.0),
            parameters.missing_cost * self._table.absent,
            parameters.reversal_cost,
            parameters.covered_cost,
        )


@compiled
def _measure_all(states: FloatArray, scan: ScanInputs, model: RatioModel) -> CableMeasures:
    return measured_cables(states, scan, model)


@compiled
def _marginal_log_ratios(log_ratios: FloatArray, polarity: PolarityPrior) -> FloatArray:
    return marginal_log_ratios(log_ratios, polarity)


@compiled_part
def measured_cables(states: FloatArray, scan: ScanInputs, model: RatioModel) -> CableMeasures:
    """Measure cables, shape (N, 8), whose borders should run through the picture."""
    measured = allocate_measures(len(states))
    fill_measures(states, 0, len(states), scan, model, scan.points_across, measured)
    return measured


@compiled_part
def fill_measures(
    states: FloatArray,
    start: int,
    stop: int,
    scan: ScanInputs,
    model: RatioModel,
    expected: float,
    measured: CableMeasures,
) -> None:
    """Fill in the measures of the states from `start` to `stop`.

    A border with less than the `expected` length in view pays for what it lacks, see
    `ScanInputs.points_across`, and means per point are taken over at least that length.
    """
    stretches = np.empty((2, 2 * CLASSES, STRETCHES), np.float32)
    striped = np.empty((2, CLASSES), np.float32)
    # Arrays of its own: in others', every addition would go through memory.
    sums, shares = np.empty((2, 2 * CLASSES), np.float32), np.empty((2, CLASSES))
    lengths = np.empty(2)
    crossings = room_for_crossings()
    for cable in range(start, stop):
        state = states[cable]
        axis = stretch_axis(state, scan)
        for border in range(2):
            line = border_line(state, border_side(border), scan)
            lines = scan.rows if line.is_steep else scan.columns
            scale = stretch_scale(axis, line)
            lengths[border] = sum_border(
                lines, line, scale, model.ratios, crossings, stretches[border], striped[border]
            )
        measured.visible_lengths[cable] = min(lengths[0], lengths[1])
        longest = max(expected, lengths[0], lengths[1])
        sum_stretches(
            stretches, striped, model.reversal_cost / model.tempering,
            model.covered_cost / model.tempering, sums,
            measured.reversed[cable], measured.covered[cable],
        )  # fmt: skip
        for border in range(2):
            _add_missing_points(max(expected - lengths[border], 0.0), model, sums[border])
        _combine_borders(sums, model.tempering, longest, shares, measured, cable)


@compiled_inside
def _add_missing_points(lacking: float, model: RatioModel, sums: Float32Array) -> None:
    """Add the ratios of the length that a border lacks in view to its sums (8,).

    A border that runs through the picture has at least as many points as the shorter side takes.
    Points beyond the edge cannot be seen, but a cable without is not believed for free.
    """
    for strength in range(CLASSES):
        cost = np.float32(lacking * model.missing[strength])
        sums[strength] += cost
        sums[CLASSES + strength] += cost


@compiled_inside
def _combine_borders(
    sums: Float32Array,
    tempering: float,
    longest: float,
    shares: FloatArray,
    measured: CableMeasures,
    cable: int,
) -> None:
    """Fill in the log-likelihood ratios of a cable from those along its borders.

    Parameters
    ----------
    sums, tempering, shares : Float32Array, float, FloatArray
        See `_log_ratio_over_strengths`.
    longest : float
        Length over which means per point are taken: that in view of the longer border, at least
        that of a border through the picture [distances of the scan lines].
    measured, cable : CableMeasures, int
        Row of the arrays that is filled in.
    """
    for polarity in range(2):
        ratio, left, right = _log_ratio_over_strengths(sums, polarity * CLASSES, tempering, shares)
        measured.log_ratios[cable, polarity] = ratio
        points = tempering * longest
        measured.border_means[cable, polarity, 0] = left / points
        measured.border_means[cable, polarity, 1] = right / points


class BorderClearness(NamedTuple):
    """How clearly the frame shows each of N cables where they are in view.

    Attributes
    ----------
    clearness : FloatArray
        Log-likelihood ratio of the weaker border per point in view of the longer one, shape (N,)
        [nats].
    shown : FloatArray
        Length in view of the shorter border, as a share of the picture's shorter side, at most 1,
        shape (N,).
    """

    clearness: FloatArray
    shown: FloatArray


@compiled_part
def border_clearness(states: FloatArray, scan: ScanInputs, model: RatioModel) -> BorderClearness:
    """Measure how clear the borders of cables are, shape (N, 8).

    What both lack of length costs nothing; what the shorter one lacks of the longer does.
    """
    count = len(states)
    clear = BorderClearness(np.zeros(count), np.zeros(count))
    measured = allocate_measures(count)
    fill_measures(states, 0, count, scan, model, ONE_POINT, measured)
    for row in range(count):
        shown = min(measured.visible_lengths[row] / scan.points_across, 1.0)
        clear.shown[row], clear.clearness[row] = shown, -math.inf
        for polarity in range(2):
            left, right = measured.border_means[row, polarity]
            clear.clearness[row] = max(clear.clearness[row], min(left, right))
    return clear


@compiled_inside
def _log_ratio_over_strengths(
    sums: Float32Array, first: int, tempering: float, shares: FloatArray
) -> tuple[float, float, float]:
    """Return the log-likelihood ratio of a cable, and those of its two borders, each alone.

    `sums`, shape (2, 8), are those of the ratios along each border, by polarity and class, not
    tempered; the classes of the polarity begin at `first`. `shares` (2, 4) is room for those of the
    classes.
    """
    left_peak, left = _log_ratio_of_border(sums[0], first, tempering, shares[0])
    right_peak, right = _log_ratio_of_border(sums[1], first, tempering, shares[1])
    joint = 0.0
    for i in range(CLASSES):
        for j in range(CLASSES):
            joint += JOINT_STRENGTHS[i, j] * shares[0, i] * shares[1, j]
    return left_peak + right_peak + math.log(joint), left, right


@compiled_inside
def _log_ratio_of_border(
    sums: Float32Array, first: int, tempering: float, shares: FloatArray
) -> tuple[float, float]:
    """Return the tempered ratio of a border's likeliest strength, and that over all of them [nats].

    `sums` (8,) and `first` are those of `_log_ratio_over_strengths`; `shares` (4,) are filled with
    the likelihoods of the strengths over that of the likeliest.
    """
    peak = sums[first]
    for strength in range(1, CLASSES):
        peak = max(peak, sums[first + strength])
    mass = 0.0
    for strength in range(CLASSES):
        shares[strength] = math.exp(tempering * (sums[first + strength] - peak))
        mass += shares[strength]
    return tempering * peak, tempering * peak + math.log(mass / CLASSES)
