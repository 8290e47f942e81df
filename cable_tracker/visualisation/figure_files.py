"""Matplotlib figures: PNG files, and the style and the lines of their panels."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cable_tracker.arrays import FloatArray
from cable_tracker.atomic_output import write_bytes
from cable_tracker.cable.model.geometry import wraps_between

DOTS_PER_INCH = 110


def figure_png(figure: Figure, dots_per_inch: int = DOTS_PER_INCH) -> bytes:
    """Return a figure as PNG."""
    buffer = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(buffer, format="png", dpi=dots_per_inch)
    return buffer.getvalue()


def write_figure(path: Path, figure: Figure) -> None:
    """Write a figure as PNG; a failure leaves no file behind.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    write_bytes(path, figure_png(figure))


def with_faint_grid(axis: Axes) -> None:
    """Give a panel a faint grid behind its lines, and no frame above and at the right."""
    axis.grid(color="0.9", linewidth=0.6)
    axis.set_axisbelow(True)
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)


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
    """Draw values (T,) at positions (T,), broken at NaN; those without neighbours become dots."""
    axis.plot(places, values, color=colour, **style)
    known = np.isfinite(values)
    padded = np.concatenate(([False], known, [False]))
    alone = known & ~padded[:-2] & ~padded[2:]
    axis.plot(places[alone], values[alone], ".", color=colour, markersize=4)
