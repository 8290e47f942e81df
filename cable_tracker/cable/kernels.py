"""Which twin of the inner loops is used: compiled ones, or NumPy."""

from __future__ import annotations

import numpy as np

from cable_tracker.cable.compiled.likelihood_ratio import CompiledLikelihoodRatio
from cable_tracker.cable.compiled.multi_hypothesis_filter import CompiledMultiHypothesisFilter
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.response_table import ResponseTable
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import uses_compiled_kernels


def make_likelihood_ratio(
    parameters: TrackerParameters, table: ResponseTable
) -> BorderLikelihoodRatio:
    """Return the learnt observation model."""
    if uses_compiled_kernels(parameters.kernels):
        return CompiledLikelihoodRatio(parameters, table)
    return BorderLikelihoodRatio(parameters, table)


def make_multi_hypothesis_filter(
    parameters: TrackerParameters,
    observation: BorderLikelihoodRatio,
    image_size: tuple[int, int],
    rng: np.random.Generator,
) -> MultiHypothesisFilter:
    """Return the filter for frames of a size [px]."""
    if isinstance(observation, CompiledLikelihoodRatio):
        return CompiledMultiHypothesisFilter(parameters, observation, image_size, rng)
    return MultiHypothesisFilter(parameters, observation, image_size, rng)
