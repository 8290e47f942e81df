"""How clearly a frame shows a cable: the basis of saying "tracking" or "lost".

The scores of the thesis say which of two hypotheses is better, not whether either is true. Here the
response along the borders of the estimate is compared with what lines without a cable give in the
same frame.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.geometry import project_borders
from cable_tracker.cable.observation import BorderObservation
from cable_tracker.cable.working_image import WorkingImage

GRID_COLUMNS, GRID_ROWS, GRID_DIRECTIONS = 24, 18, 4
NOISE_FLOOR = 0.3
"""Smallest robust scale of a frame [grey levels]: below it lies the noise of quantisation."""

GAUSSIAN_MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""

MINIMUM_POINTS = 3.0
"""A border with fewer points inside the image shows nothing."""


def response_scale(model: BorderObservation, image: WorkingImage) -> float:
    """Return a robust standard deviation of the filter's response over the frame [grey levels].

    Taken at a regular grid of points, across lines of four directions. A cable covers too little of
    the image to move the median.
    """
    width, height = image.frame_size
    x = ((np.arange(GRID_COLUMNS) + 0.5) / GRID_COLUMNS - 0.5) * width
    y = ((np.arange(GRID_ROWS) + 0.5) / GRID_ROWS - 0.5) * height
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    angles = np.pi * (np.arange(len(points)) % GRID_DIRECTIONS) / GRID_DIRECTIONS
    responses = model.respond_at(image, points, angles)
    return max(GAUSSIAN_MAD * float(np.median(np.abs(responses))), NOISE_FLOOR)


def border_evidence(model: BorderObservation, state: FloatArray, image: WorkingImage) -> float:
    """Return the mean response per point of the weaker border, in units of the frame's scale.

    Zero when the borders do not oppose each other, or lie outside the image. `state`: shape (8,).
    """
    responses = model.measure(project_borders(state[None, :]), image)
    if not responses.opposed()[0] or responses.counts.min() < MINIMUM_POINTS:
        return 0.0
    weaker = float((np.abs(responses.sums) / responses.counts).min())
    return weaker / response_scale(model, image)
