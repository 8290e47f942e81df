"""Metres of a cable in a frame's report: to the last bit, or the reason for their absence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.sequences.tables.estimates import RowMetres

METRES_KEYS = tuple(field.name for field in fields(RowMetres))
"""What is known of a cable in metres, as in the table of estimates."""

NO_METRES_KEY = "no_metres"
"""Why there are no metres."""


def row_metres(known: CrossTrack) -> RowMetres:
    """Return a cable's metres for tables and reports."""
    sigma = known.standard_deviations()
    return RowMetres(known.offset, known.heading, float(sigma[0]), float(sigma[2]))


def cable_facts(known: CrossTrack | Withheld) -> dict[str, str]:
    """Return the facts about one frame, those that are known."""
    if isinstance(known, Withheld):
        return {NO_METRES_KEY: str(known)}
    row = row_metres(known)
    return {key: repr(getattr(row, key)) for key in METRES_KEYS}


def read_row_metres(facts: Mapping[str, str]) -> RowMetres | None:
    """Return the metres that the facts of a frame hold; None: they hold none."""
    if not has_metres(facts):
        return None
    return RowMetres(*(float(facts[key]) for key in METRES_KEYS))


def has_metres(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold metres."""
    return METRES_KEYS[0] in facts
