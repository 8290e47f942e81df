"""Probability that the cable is brighter than the bottom, after all frames seen."""

from __future__ import annotations

from cable_tracker.tracking.rates import over_time

POLARITY_DOUBT = 0.02
"""The probability that the cable is bright stays this far from 0 and 1."""


def updated_p_bright(
    before: float, found: float, presence: float, memory: float, dt: float
) -> float:
    """Return the probability that the cable is bright, after a frame.

    Parameters
    ----------
    before : float
        That probability before the frame.
    found : float
        Share of the particles' weight that speaks for a bright cable.
    presence : float
        Probability that there is a cable: without one the frame says nothing.
    memory : float
        Factor per frame at 25 frames per second on the deviation from 0.5, 0 to 1.
    dt : float
        Time since the frame before [s].
    """
    kept = over_time(memory, dt)
    now = presence * found + (1.0 - presence) * before
    p_bright = kept * now + (1.0 - kept) * 0.5
    return float(min(max(p_bright, POLARITY_DOUBT), 1.0 - POLARITY_DOUBT))
