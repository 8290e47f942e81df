"""The particles of a frame while they are drawn, and their weights.

The importance weight of a particle is f L / q: f the density before the frame, L the likelihood
ratio of the frame, q the density of the mixture of all proposals times the number of particles. So
no proposal acts as a second prior.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.predict.predicted_density import DensityValues, empty_densities
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BRIGHT,
    DARK,
    CableMeasures,
    PolarityPrior,
    allocate_measures,
    marginal_log_ratio,
)
from cable_tracker.cable.model.geometry import borders_cross_inside
from cable_tracker.cable.model.limits import StateLimits
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.compilation import compiled_loop, compiled_part


class Sample(NamedTuple):
    """Room for N particles of a frame.

    Attributes
    ----------
    states : FloatArray
        The particles, shape (N, 8), in the chart about one reference angle.
    densities : DensityValues
        Densities before the frame is looked at.
    measured : CableMeasures
        Log-likelihood ratios of the frame, for either polarity.
    map_log_ratios : FloatArray
        What the map of the frame adds, shape (N,); 0 without one [nats].
    log_likelihoods : FloatArray
        Log-likelihood ratios averaged over the polarity, plus `map_log_ratios` and the width
        penalties, shape (N,); -inf for impossible poses [nats].
    proposal_density : FloatArray
        Density q of the mixture of proposals that the particles were drawn from, times their
        number, shape (N,).
    """

    states: FloatArray
    densities: DensityValues
    measured: CableMeasures
    map_log_ratios: FloatArray
    log_likelihoods: FloatArray
    proposal_density: FloatArray


def empty_sample(count: int) -> Sample:
    """Return room for some particles."""
    return Sample(
        np.empty((count, STATE_SIZE)),
        empty_densities(count),
        allocate_measures(count),
        np.zeros(count),
        np.empty(count),
        np.empty(count),
    )


@compiled_loop
def fill_log_likelihoods(
    sample: Sample,
    start: int,
    stop: int,
    polarity: PolarityPrior,
    limits: StateLimits,
    image_size: tuple[float, float],
) -> None:
    """Fill in the log-likelihoods from `start` to `stop`.

    Impossible are poses beyond the limits, and those whose borders cross inside the image.
    """
    for row in range(start, stop):
        state, log_ratios = sample.states[row], sample.measured.log_ratios[row]
        possible = not borders_cross_inside(state, image_size)
        for column in range(POSE_SIZE):
            value = state[column]
            possible = possible and limits.lower[column] <= value <= limits.upper[column]
        if not possible:
            sample.log_likelihoods[row] = -math.inf
            continue
        ratio = marginal_log_ratio(polarity, log_ratios[BRIGHT], log_ratios[DARK])
        ratio += sample.map_log_ratios[row]
        sample.log_likelihoods[row] = ratio + sample.densities.width_penalties[row]


@compiled_part
def importance_log_weights(sample: Sample, count: int, power: float) -> FloatArray:
    """Return log(f L^power / q) of the first particles, shape (count,)."""
    weights = np.empty(count)
    for row in range(count):
        prior, proposal = sample.densities.prior[row], sample.proposal_density[row]
        if prior <= 0.0 or proposal <= 0.0:
            weights[row] = -math.inf
            continue
        # Zero times -inf, the ratio of what is impossible, is no number.
        ratio = power * sample.log_likelihoods[row] if power > 0.0 else 0.0
        weights[row] = ratio + np.log(prior / proposal)
    return weights
