"""What a strip's width asks of its evidence.

Any bottom has thin lines, and few wide ones: what is claimed where there is no cable is thin more
often than cables are. So evidence for thin strips counts less.
"""

from __future__ import annotations

import math

from cable_tracker.compilation import compiled_inside

THINNEST_FACTOR = 0.5
"""Lower bound of `thin_factor`."""

LEAST_TRUSTED, MOST_TRUSTED = 4.0 / 3.0, 2.0
"""Widths, in units of `thin_width`, up to which what speaks for a strip in its appearance does not
count, and from which it counts fully; linear between."""


@compiled_inside
def thin_factor(width: float, thin_width: float) -> float:
    """Return the factor on the evidence for a strip of a width: sqrt(width / thin_width), 0.5 to 1.

    Any bottom has thin lines.
    """
    return min(max(math.sqrt(max(width, 0.0) / thin_width), THINNEST_FACTOR), 1.0)


@compiled_inside
def trusted_share(width: float, thin_width: float) -> float:
    """Return how far the appearance of a strip of a width counts, 0 to 1."""
    share = (width / thin_width - LEAST_TRUSTED) / (MOST_TRUSTED - LEAST_TRUSTED)
    return min(max(share, 0.0), 1.0)


@compiled_inside
def trusted_appearance(appearance: float, width: float, thin_width: float) -> float:
    """Return what counts of a strip's appearance [nats]: of a thin one only what speaks against it.

    A rope on the bottom has a cable's looks, and there is no inside of it to be looked at.
    """
    share = trusted_share(width, thin_width)
    return share * appearance + (1.0 - share) * min(appearance, 0.0)
