"""Reasons why no cable was claimed in a whole recording, and advice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cable_tracker.cable.hypotheses.claim import needed_clearness
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH
from cable_tracker.tracking.status import REFUSED, TrackingStatus

TRACKING = TrackingStatus.TRACKING.value
NEAR_LIMIT = 1.1
"""Factor of a limit within which a width counts as held by it."""

MOST_DIGITS = 17
"""Significant digits that write any float exactly."""


def advice(
    rows: Sequence[EstimateRow],
    widths: Sequence[tuple[float, int]],
    parameters: TrackerParameters,
) -> list[str]:
    """Return lines that explain why no cable was claimed; none if one was.

    Parameters
    ----------
    rows : sequence of EstimateRow
        All frames of the recording.
    widths : sequence of (float, int)
        Width of the leading hypothesis and of the image, of the frames that have one [px].
    parameters : TrackerParameters
        Parameters of the tracker that ran on the recording.
    """
    if not rows or any(row.status == TRACKING for row in rows):
        return []
    lines = ["no cable was claimed in any frame"]
    presence = [row.presence for row in rows if row.presence is not None]
    evidence = [row.evidence for row in rows if row.evidence is not None]
    is_likely = bool(presence) and max(presence) >= parameters.presence_to_track
    width = _median_width(widths)
    asking, needed = _evidence_for_a_claim(parameters, width)
    is_clear = bool(evidence) and max(evidence) >= needed
    if presence and not is_likely:
        lines.append(
            f"presence: at most {_below(100 * max(presence), 100 * parameters.presence_to_track)}%,"
            f" presence_to_track asks for {100 * parameters.presence_to_track:g}%; is the cable in"
            " view, with both its borders?"
        )
    if evidence and not is_clear:
        reached = _below(max(evidence), needed)
        lines.append(
            f"evidence: the weaker border reached {reached}, {asking} asks for"
            f" {needed:g}{_more_for_thin(needed, width, parameters)}; try a lower one, or learn a"
            " response table from labelled frames of yours (cable-tracker label, learn)"
        )
    if is_likely and is_clear:
        lines.append(_confirmation_advice(rows, parameters))
    if width is not None:
        lines += _width_advice(width, parameters)
    lines.append("docs/troubleshooting.md says what else to try; cable-tracker gui shows why")
    return lines


def _below(value: float, limit: float) -> str:
    """Return a value in as few digits, three at least, as show that it is below a limit."""
    texts = (f"{value:.{digits}g}" for digits in range(3, MOST_DIGITS))
    return next((text for text in texts if float(text) < limit), repr(value))


def _confirmation_advice(rows: Sequence[EstimateRow], parameters: TrackerParameters) -> str:
    """Return why frames that support a claim led to none."""
    begun = [row.event for row in rows if row.event and row.status != REFUSED]
    if 2 * len(begun) >= len(rows):
        return (
            f"tracking started anew in {len(begun)} of {len(rows)} frames, for example:"
            f" {begun[-1]}; a claim takes confirmation_time"
            f" ({parameters.confirmation_time:g} s) without that. Where frames come more seldom,"
            f" raise maximum_gap ({parameters.maximum_gap:g} s)"
        )
    stamps = [row.stamp for row in rows if row.status != REFUSED]
    needed, usable = parameters.confirmation_time, (stamps[-1] - stamps[0]) / NANOSECONDS
    if usable < needed:
        return (
            f"usable frames span {_below(usable, needed)} s, a claim takes confirmation_time"
            f" ({needed:g} s); look into why frames were refused, or record for longer"
        )
    together = (
        "presence and evidence were high enough, but not together for confirmation_time"
        f" ({needed:g} s); try a shorter one"
    )
    if not parameters.uses_map:
        return together
    return (
        f"{together}, or a lower overlap_to_find ({parameters.overlap_to_find:g}): the network may"
        " take more for a cable than this one"
    )


def _median_width(widths: Sequence[tuple[float, int]]) -> float | None:
    """Return the median width [px at the reference width]; None without any."""
    if not widths:
        return None
    return float(np.median([width * REFERENCE_WIDTH / image for width, image in widths]))


def _evidence_for_a_claim(parameters: TrackerParameters, width: float | None) -> tuple[str, float]:
    """Return the parameter that the first claim needs most evidence for, and how much.

    `width` is that of the cable [px at the reference width]; None: not known.
    """
    tracked, found = parameters.evidence_to_track, parameters.evidence_to_find
    if width is not None and parameters.looks == "borders":
        found = needed_clearness(width, parameters, 1.0)
    if parameters.filter == "multi_hypothesis" and found > tracked:
        return "evidence_to_find", found
    return "evidence_to_track", tracked


def _more_for_thin(needed: float, width: float | None, parameters: TrackerParameters) -> str:
    """Return why a thin cable needs more than `evidence_to_find`, and the remedy.

    `width` is that of the cable [px at the reference width]; None: not known.
    """
    if width is None or needed <= parameters.evidence_to_find or width >= parameters.thin_width:
        return ""
    factor = needed / parameters.evidence_to_find
    return (
        f" ({factor:.2g} times {parameters.evidence_to_find:g}, for {width:.1f} px at 320 px is"
        f" thin: lower thin_width to the width of the cable first)"
    )


def _width_advice(width: float, parameters: TrackerParameters) -> list[str]:
    low, high = parameters.width_minimum, parameters.initial_width_maximum
    if width <= NEAR_LIMIT * max(low, parameters.initial_width_minimum):
        return [
            f"width: {width:.0f} px at 320 px, at its lower limit; for a thinner cable lower"
            " initial_width_minimum and width_minimum"
        ]
    if width >= high / NEAR_LIMIT:
        return [
            f"width: {width:.0f} px at 320 px, at its upper limit; for a wider one raise"
            " initial_width_maximum and width_maximum"
        ]
    return []
