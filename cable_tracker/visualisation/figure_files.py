"""Figures of matplotlib as PNG, and the look that their panels share."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cable_tracker.atomic_output import write_bytes

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
