"""Twin of `cable.evidence`."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.thesis.evidence import GAUSSIAN_MAD, MINIMUM_POINTS, NOISE_FLOOR
from cable_tracker.cable.thesis.observation import SMALLEST_SUM
from cable_tracker.compilation import compiled


@compiled
def median(values: Image) -> float:
    """Return the median of values (G,), which are left in another order (Hoare, 1961)."""
    middle = len(values) // 2
    low, high = 0, len(values) - 1
    while low < high:
        pivot = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            break
    upper = float(values[middle])
    if len(values) % 2 == 1:
        return upper
    lower = float(values[0])
    for k in range(1, middle):
        lower = max(lower, float(values[k]))
    return (lower + upper) / 2


@compiled
def border_evidence(scores: FloatArray, counts: FloatArray, scattered: Image) -> float:
    """Return the evidence for one cable from its borders' sums of answers (2,) and counts (2,).

    `scattered` are moduli of answers all over the frame, shape (G,).
    """
    left, right = scores[0], scores[1]
    opposed = left * right < 0.0 and min(abs(left), abs(right)) > SMALLEST_SUM
    if not opposed or min(counts[0], counts[1]) < MINIMUM_POINTS:
        return 0.0
    scale = max(GAUSSIAN_MAD * median(scattered), NOISE_FLOOR)
    return min(abs(left) / counts[0], abs(right) / counts[1]) / scale
