"""How clear a cable must be to be claimed when nothing was known of it.

Any bottom has thin lines, and few wide ones: what is claimed where there is no cable is thin more
often than cables are. So a thin hypothesis has to be clearer than a wide one. What counts is how
clear its borders are where they are in view: a strip that crosses a corner of the picture may be as
clear as any.
"""

from __future__ import annotations

from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters

USUAL_WIDTH = 2.0
"""Width, in units of `thin_width`, at which the clearness that is needed is `evidence_to_find`."""

LEAST_FACTOR, MOST_FACTOR = 2.0 / 3.0, 3.0
"""Limits of the factor on `evidence_to_find`, for wide and for thin strips. Chosen on the simulated
worlds to tune on (`tune_*`) and on crisp strips."""


def needed_clearness(width: float, parameters: TrackerParameters, image_width: float) -> float:
    """Return the clearness that the first claim of a cable needs [nats per point].

    Parameters
    ----------
    width : float
        Width of the cable [px].
    parameters : TrackerParameters
        `evidence_to_find` and `thin_width`.
    image_width : float
        Width of the frames [px].
    """
    needed = parameters.evidence_to_find
    if needed <= 0.0:
        return needed
    usual = USUAL_WIDTH * parameters.thin_width * image_width / REFERENCE_WIDTH
    return needed * min(max(usual / max(width, 1e-9), LEAST_FACTOR), MOST_FACTOR)
