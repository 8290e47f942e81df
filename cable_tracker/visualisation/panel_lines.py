"""Lines of a cable's parameters over frames or time."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wraps_between


def broken_at_wraps(
    places: FloatArray, angles: FloatArray, *values: FloatArray
) -> tuple[FloatArray, ...]:
    """Return places and values, each (T,), with NaN put in where angles (T,) wrap [rad].

    There d and beta change their signs with the angle, and a line would run across the panel.
    """
    wraps = np.flatnonzero(wraps_between(angles)) + 1
    return tuple(np.insert(each, wraps, np.nan) for each in (places, *values))


def draw_line(
    axis: Axes,
    places: FloatArray,
    values: FloatArray,
    colour: Any,  # noqa: ANN401  What matplotlib takes.
    **style: Any,  # noqa: ANN401
) -> None:
    """Draw values (T,) at places (T,), broken at NaN; those without neighbours become dots."""
    axis.plot(places, values, color=colour, **style)
    known = np.isfinite(values)
    padded = np.concatenate(([False], known, [False]))
    alone = known & ~padded[:-2] & ~padded[2:]
    axis.plot(places[alone], values[alone], ".", color=colour, markersize=4)
