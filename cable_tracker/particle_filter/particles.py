"""Weighted particles: their weights in log space, resampling, and point estimates.

Resampling draws particles with a frequency proportional to their weight. Every scheme is unbiased:
particle i is drawn ``count * weights[i]`` times on average. They differ in the variance that they
add. All take the weights, shape (N,), summing to one; the number of particles to draw; and a random
generator; and return indices, shape (count,).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.compilation import compiled, compiled_loop, compiled_part

ResamplingScheme: TypeAlias = Callable[[FloatArray, int, np.random.Generator], IndexArray]

ROUNDING = 1e-9
"""An expected number of copies this much below a whole number is that number."""


SMALLEST_STEP = 1e-300
"""Steps that are all zero have no sum to divide by."""


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """N weighted hypotheses about a state of k components. Never changed in place.

    Attributes
    ----------
    states : FloatArray
        States, shape (N, k), N >= 1.
    log_weights : FloatArray
        Log-weights, shape (N,), normalised: the exponentials sum to one.

    Raises
    ------
    ValueError
        The shapes do not belong together, or there is no particle.
    """

    states: FloatArray
    log_weights: FloatArray

    def __post_init__(self) -> None:
        if self.states.ndim != 2 or len(self.states) == 0:
            raise ValueError(f"states must have shape (N >= 1, k), not {self.states.shape}")
        if self.log_weights.shape != (len(self.states),):
            raise ValueError(
                f"log_weights must have shape ({len(self.states)},), not {self.log_weights.shape}"
            )

    @classmethod
    def equally_weighted(cls, states: FloatArray) -> Particles:
        """Give every state the same weight."""
        return cls(states, uniform_log_weights(len(states)))

    @property
    def count(self) -> int:
        """Number of particles, N."""
        return len(self.states)

    @property
    def weights(self) -> FloatArray:
        """Weights on the linear scale, shape (N,), summing to one."""
        weights: FloatArray = np.exp(self.log_weights)
        return weights

    def moved_to(self, states: FloatArray) -> Particles:
        """Return particles with these states and the same weights."""
        return Particles(states, self.log_weights)

    def reweighted(self, log_likelihoods: FloatArray) -> Particles:
        """Multiply the weights by likelihoods, shape (N,), and normalise them.

        Where no particle has a positive weight left, the weights stay those of before: an
        observation that excludes everything is no information.
        """
        if log_likelihoods.shape != self.log_weights.shape:
            raise ValueError(
                f"log_likelihoods must have shape {self.log_weights.shape},"
                f" not {log_likelihoods.shape}"
            )
        # A weight of zero times an infinite likelihood is NaN here, and zero after normalisation.
        with np.errstate(invalid="ignore", over="ignore"):
            products = self.log_weights + log_likelihoods
        posterior = normalise_log_weights(products)
        if posterior.degenerate:
            return self
        return Particles(self.states, posterior.log_weights)

    def selected(self, indices: IndexArray) -> Particles:
        """Return the particles at `indices`, equally weighted."""
        return Particles.equally_weighted(self.states[indices])


class NormalisedWeights(NamedTuple):
    """Log-weights whose exponentials sum to one.

    Attributes
    ----------
    log_weights : FloatArray
        Normalised log-weights, shape (N,).
    degenerate : bool
        True when no particle had a positive weight. The weights are uniform then: an observation
        that excludes every particle says nothing about which of them is better.
    """

    log_weights: FloatArray
    degenerate: bool


@compiled_part
def exponentials(values: FloatArray) -> FloatArray:
    """Return exp(values), shape (N,). Within a kernel NumPy's own takes long to compile."""
    result = np.empty(len(values))
    for row in range(len(values)):
        result[row] = math.exp(values[row])
    return result


@compiled
def log_sum_exp(values: FloatArray) -> float:
    """Return log(sum(exp(values))) without overflow or underflow; -inf for weights all zero."""
    peak = -math.inf
    for value in values:
        peak = max(peak, value)
    if not math.isfinite(peak):
        return peak
    total = 0.0
    for value in values:
        total += math.exp(value - peak)
    return peak + math.log(total)


@compiled_loop
def masked_log_sum_exp(values: FloatArray, labels: IndexArray, label: int) -> float:
    """Return log(sum(exp(values))) over the rows of one label, shapes (N,); -inf for none."""
    peak = -math.inf
    for row in range(len(labels)):
        if labels[row] == label:
            peak = max(peak, values[row])
    if peak == -math.inf:
        return peak
    total = 0.0
    for row in range(len(labels)):
        if labels[row] == label:
            total += math.exp(values[row] - peak)
    return peak + math.log(total)


def uniform_log_weights(count: int) -> FloatArray:
    """Return `count` equal log-weights that sum to one."""
    return np.full(count, -np.log(count))


@compiled
def normalise_log_weights(log_weights: FloatArray) -> NormalisedWeights:
    """Scale weights to sum to one.

    NaN counts as weight zero. Weights of plus infinity share the whole mass equally.

    Parameters
    ----------
    log_weights : FloatArray
        Log-weights, shape (N,), N >= 1.
    """
    peak, infinite = -math.inf, 0
    for value in log_weights:
        if value == math.inf:
            infinite += 1
        elif value > peak:
            peak = value
    result = np.full(len(log_weights), -math.inf)
    if infinite:
        for row in range(len(log_weights)):
            if log_weights[row] == math.inf:
                result[row] = -math.log(infinite)
        return NormalisedWeights(result, False)
    if peak == -math.inf:
        for row in range(len(log_weights)):
            result[row] = -math.log(len(log_weights))
        return NormalisedWeights(result, True)
    total = 0.0
    for value in log_weights:
        if not math.isnan(value):
            total += math.exp(value - peak)
    log_total = math.log(total)
    for row in range(len(log_weights)):
        if not math.isnan(log_weights[row]):
            # The peak goes first: a sum beside a large peak would be rounded away.
            result[row] = log_weights[row] - peak - log_total
    return NormalisedWeights(result, False)


@compiled
def effective_sample_size(log_weights: FloatArray) -> float:
    """Return N_eff = 1 / sum(weight^2) of normalised weights (thesis, section 3.3.3).

    Between 1, when one particle has all the weight, and N, when all weights are equal.
    """
    # Relative to the largest weight, so that equal weights give N without a rounding error, which
    # would make a filter resample that has no reason to.
    peak = -math.inf
    for value in log_weights:
        peak = max(peak, value)
    total, squares = 0.0, 0.0
    for value in log_weights:
        relative = math.exp(value - peak)
        total += relative
        squares += relative * relative
    return min(max(total * total / squares, 1.0), float(len(log_weights)))


def _invert_cumulative_weights(weights: FloatArray, positions: FloatArray) -> IndexArray:
    """Return the particle on which each position from 0 to 1 falls, shape (count,)."""
    reached = np.cumsum(weights)
    total = reached[-1]
    # Scaling the positions instead of forcing the last sum to one: rounding must neither draw a
    # particle of weight zero at the end nor run past it.
    found = np.searchsorted(reached, positions * total, side="right")
    indices: IndexArray = np.minimum(found, np.searchsorted(reached, total))
    return indices


def multinomial_positions(count: int, rng: np.random.Generator) -> FloatArray:
    """Draw independent positions in [0, 1), and sort them; shape (count,).

    Sorted, they are distributed like the partial sums of exponential numbers over the whole sum,
    which takes no sorting (Devroye, 1986, section V.3).
    """
    # In place, for with many particles the time goes into memory.
    steps = rng.random(count + 1)
    np.subtract(1.0, steps, out=steps)
    np.log(steps, out=steps)
    np.negative(steps, out=steps)
    np.maximum(steps, SMALLEST_STEP, out=steps)
    np.cumsum(steps, out=steps)
    steps /= steps[-1]
    positions: FloatArray = steps[:-1]
    return positions


def multinomial_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw independently, by search in the cumulative weights (thesis, section 3.3.3)."""
    return _invert_cumulative_weights(weights, multinomial_positions(count, rng))


def stratified_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw one position at random from each of `count` equal strata (Kitagawa, 1996)."""
    return _invert_cumulative_weights(weights, (np.arange(count) + rng.random(count)) / count)


def systematic_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw equally spaced positions with one random offset (Carpenter et al., 1999)."""
    return _invert_cumulative_weights(weights, (np.arange(count) + rng.random()) / count)


def residual_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Copy each particle floor(count * weight) times, draw the rest at random (Liu, Chen, 1998)."""
    expected = weights * count
    # A weight of 1/N that rounding has made a little smaller still earns its copy.
    copies = np.floor(expected + ROUNDING).astype(np.int64)
    certain = np.repeat(np.arange(len(weights), dtype=np.int64), copies)
    missing = count - len(certain)
    if missing <= 0:
        return certain[:count]
    residual = np.maximum(expected - copies, 0.0)
    total = residual.sum()
    # Rounding may leave a missing particle without a residual to draw it from.
    rest = residual / total if total > 0 else weights
    return np.concatenate((certain, multinomial_resampling(rest, missing, rng)))


RESAMPLING_SCHEMES: Mapping[str, ResamplingScheme] = MappingProxyType(
    {
        "multinomial": multinomial_resampling,
        "stratified": stratified_resampling,
        "systematic": systematic_resampling,
        "residual": residual_resampling,
    }
)


def weighted_mean(states: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighted mean, shape (k,), of states (N, k): the MMSE estimate.

    `weights` has shape (N,) and sums to one.
    """
    return weights @ states


def weighted_covariance(states: FloatArray, weights: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the weighted covariance, shape (k, k), of states (N, k) about their mean (k,).

    Symmetric and positive semi-definite; zero for a single particle. It is the second central
    moment of the weighted sample, without a correction for the sample size.
    """
    deviations = states - mean
    covariance = (deviations * weights[:, None]).T @ deviations
    symmetric: FloatArray = (covariance + covariance.T) / 2
    return symmetric


def standard_deviations(covariance: FloatArray) -> FloatArray:
    """Return the square roots of a covariance's diagonal, shape (k,); 0 for what is below 0."""
    variances: FloatArray = np.maximum(np.diag(covariance), 0.0)
    return np.sqrt(variances)
