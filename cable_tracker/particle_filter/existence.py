"""Whether the thing that is tracked exists at all: the Bernoulli filter's probability of existence.

References
----------
B. Ristic, B.-T. Vo, B.-N. Vo and A. Farina (2013), "A tutorial on Bernoulli filters: theory,
implementation and applications". J. Ha (2008, section 6.6) has the same two-state Markov chain for
a cable that leaves the image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.compilation import compiled_inside

LARGEST_LOG_ODDS = 700.0
"""The exponential of larger ones overflows."""


@compiled_inside
def probability_of(log_odds: float) -> float:
    """Return the probability that has these log-odds."""
    return 1.0 / (1.0 + math.exp(min(max(-log_odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)))


@compiled_inside
def log_odds_of(probability: float) -> float:
    """Return the log-odds of a probability above 0 and below 1."""
    return math.log(probability) - math.log1p(-probability)


@dataclass(frozen=True, slots=True)
class PredictedExistence:
    """Probabilities of how the thing comes to exist at the next observation.

    Attributes
    ----------
    survived : float
        It existed before and still does.
    born : float
        It did not and now does.
    """

    survived: float
    born: float

    @property
    def total(self) -> float:
        """Probability that it exists, before the observation."""
        return self.survived + self.born


def predict_existence(probability: float, survival: float, birth: float) -> PredictedExistence:
    """Predict existence from one observation to the next.

    `probability` that it existed, of `survival` if it did, and of `birth` if it did not, 0 to 1.
    """
    return PredictedExistence(probability * survival, (1.0 - probability) * birth)


def update_existence(
    predicted: PredictedExistence, log_evidence: float, least: float, most: float
) -> float:
    """Return the probability of existence after an observation.

    Parameters
    ----------
    predicted : PredictedExistence
        Probabilities before the observation.
    log_evidence : float
        Logarithm of the likelihood ratio, observation with the thing against without it, integrated
        over the predicted density, which integrates to `predicted.total`, not to 1.
    least, most : float
        The probability stays between these, above 0 and below 1, so that it can turn again in time.
    """
    absent = 1.0 - predicted.total
    if log_evidence == -math.inf:
        return least
    probability = probability_of(log_evidence - math.log(max(absent, 1e-300)))
    return min(max(probability, least), most)
