"""How far borders may lie from where the likelihood sees them.

Growth, shadow and the roundness of a cable shift each border as a whole, by the same in frame
after frame; particles agree on the wrong place then.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters

CLEAR_EVIDENCE, EVIDENCE_STEP, LARGEST_FACTOR = 1.7, 0.4, 4.0
"""Borders with less evidence are displaced farther: by `border_displacement` more for each step
that it is less than that of clear ones, up to the factor."""

BORDER_TURN = float(np.deg2rad(0.4))
"""Turn of a border that is displaced by one pixel of the reference width [rad]."""


def displacement_covariance(parameters: TrackerParameters, image_width: int) -> FloatArray:
    """Return the covariance (8, 8) of what the likelihood does not know."""
    border = parameters.border_displacement * image_width / REFERENCE_WIDTH
    turn = parameters.border_displacement * BORDER_TURN
    variances = np.zeros(STATE_SIZE)
    # d and alpha are means of the two borders, w is their difference, beta half of it.
    variances[:POSE_SIZE] = [border**2 / 2, turn**2 / 2, 2 * border**2, turn**2 / 2]
    return np.diag(variances)


def displacement_factor(evidence: float) -> float:
    """Return how many times `border_displacement` a border with some evidence is displaced."""
    return min(max(1.0 + (CLEAR_EVIDENCE - evidence) / EVIDENCE_STEP, 1.0), LARGEST_FACTOR)
