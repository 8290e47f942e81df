"""Metres of a target in a frame's report: to the last bit, or the reason for their absence."""

from __future__ import annotations

from collections.abc import Mapping

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Withheld

BEARING_KEYS = ("bearing_x", "bearing_y", "bearing_z")
"""Unit vector in the camera's optical frame."""

PLACE_KEYS = ("x", "y", "z", "range", "range_sigma")
"""Place in base_link, and range from the camera [m]."""

WHY_NOT_KEY = "why_not"
"""Why there is no position."""

TARGET_METRES_KEYS = (*BEARING_KEYS, *PLACE_KEYS, WHY_NOT_KEY)
"""All keys of a target's metres, in the order of the table in metres."""


def target_facts(metres: TargetMetres, camera_position: FloatArray) -> dict[str, str]:
    """Return the facts about one frame, those that are known.

    Parameters
    ----------
    metres : TargetMetres
        Metric estimate of the target.
    camera_position : FloatArray
        Position of the camera in base_link, shape (3,) [m].
    """
    facts: dict[str, str] = {}
    if not isinstance(metres.ray, Withheld):
        facts |= zip(BEARING_KEYS, (repr(float(value)) for value in metres.ray), strict=True)
    if isinstance(metres.relative, RelativeState):
        state = metres.relative
        numbers = (*(state.position() + camera_position), state.range, state.range_sigma)
        facts |= zip(PLACE_KEYS, (repr(float(value)) for value in numbers), strict=True)
    else:
        facts[WHY_NOT_KEY] = str(metres.relative)
    return facts


def has_bearing(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold a bearing."""
    return BEARING_KEYS[0] in facts


def has_position(facts: Mapping[str, str]) -> bool:
    """Tell whether the facts of a frame hold a position."""
    return PLACE_KEYS[0] in facts
