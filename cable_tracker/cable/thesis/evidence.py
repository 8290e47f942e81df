"""How clearly a frame shows a cable: the basis of saying "tracking" or "lost".

The scores of the thesis say which of two hypotheses is better, not whether either is true. Here the
response along the borders of the estimate is compared with what lines without a cable give in the
same frame.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import Borders, project_borders
from cable_tracker.cable.thesis.observation import BorderResponses

NOISE_FLOOR = 0.3
"""Smallest robust scale of a frame [grey levels]: below it lies the noise of quantisation."""

GAUSSIAN_MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""

MINIMUM_POINTS = 3.0
"""A border with fewer points inside the image shows nothing."""


class ResponseModel(Protocol):
    """A way of measuring the filter's answers."""

    def measure(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        """Sum the answers along each border."""
        ...

    def scattered_responses(self, image: WorkingImage) -> FloatArray:
        """Return the answers at places all over the frame [grey levels], shape (G,)."""
        ...


def response_scale(model: ResponseModel, image: WorkingImage) -> float:
    """Return a robust standard deviation of the filter's response over the frame [grey levels].

    Taken at places all over it. A cable covers too little of the image to move the median.
    """
    responses = model.scattered_responses(image)
    return max(GAUSSIAN_MAD * float(np.median(np.abs(responses))), NOISE_FLOOR)


def border_evidence(model: ResponseModel, state: FloatArray, image: WorkingImage) -> float:
    """Return the mean response per point of the weaker border, in units of the frame's scale.

    Zero when the borders do not oppose each other, or lie outside the image. `state`: shape (8,).
    """
    responses = model.measure(project_borders(state[None, :]), image)
    if not responses.opposed()[0] or responses.counts.min() < MINIMUM_POINTS:
        return 0.0
    weaker = float((np.abs(responses.sums) / responses.counts).min())
    return weaker / response_scale(model, image)
