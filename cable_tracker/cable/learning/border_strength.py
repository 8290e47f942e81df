"""How strong a border is, and which class it belongs to."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Float32Array
from cable_tracker.cable.measure.borders.response_bins import STRENGTHS


def border_strength(responses: Float32Array) -> float:
    """Return how strong a border is: the mean of the upper half of its responses (P,), signed."""
    highest = np.sort(responses)[::-1][: (len(responses) + 1) // 2]
    return float(highest.mean()) if len(highest) else 0.0


def strength_class(strength: float) -> int:
    """Return the class of a strength, -1 for one that is too faint for any."""
    return int(np.searchsorted(STRENGTHS, strength, side="right")) - 1
