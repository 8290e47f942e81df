"""Figures about runs, drawn with matplotlib, as SVG text or PNG bytes."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from cable_tracker.arrays import BoolArray, FloatArray, true_runs
from cable_tracker.cable.model.state import ANGLE, POSE_COMPONENTS, POSE_SIZE
from cable_tracker.evaluation.consistency import coverage
from cable_tracker.evaluation.runs import RunResult, chosen, methods_of
from cable_tracker.evaluation.sample_statistics import percentages
from cable_tracker.evaluation.trace import Trace
from cable_tracker.visualisation.palette import ESTIMATE, GREY, RED, to_unit
from cable_tracker.visualisation.plots import (
    broken_at_wraps,
    draw_line,
    figure_png,
    with_faint_grid,
)

DOTS_PER_INCH = 130
NOMINAL = np.linspace(0.02, 0.98, 49)
"""Probabilities at which the calibration is compared."""

SERIES_STYLES = (
    ("#0072b2", "-"), ("#d55e00", "-"), ("#009e73", "-"), ("#cc79a7", "-"), ("#56b4e9", "--"),
    ("#e69f00", "--"), ("#444444", "--"), ("#999999", ":"),
)  # fmt: skip
"""Colours that stay apart for the colour-blind, and strokes."""

_STYLE: Any = {
    "font.size": 8.0,
    "axes.edgecolor": "0.4",
    "axes.linewidth": 0.6,
    "axes.labelcolor": "0.2",
    "xtick.color": "0.3",
    "ytick.color": "0.3",
    "lines.linewidth": 1.2,
    "svg.fonttype": "none",
    "svg.hashsalt": "cable_tracker",
}


SMALLEST_SPANS = (20.0, 10.0, 20.0, 5.0)
"""Smallest ranges of the axes of d, alpha, w, beta [px, deg]: small errors must not fill them."""

LOSS_COLOURS = LinearSegmentedColormap.from_list(
    "loss", ["#f4f6f7", "#f3c19d", "#d55e00", "#7a2d00"]
)
"""Colours from never lost to always lost."""


def _calm_style() -> AbstractContextManager[None]:
    return mpl.rc_context(_STYLE)


def as_svg(figure: Figure) -> str:
    """Return a figure as SVG; the same figure gives the same text."""
    buffer = io.StringIO()
    with _calm_style():
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


def as_png(figure: Figure) -> bytes:
    """Return a figure as PNG."""
    with _calm_style():
        return figure_png(figure, DOTS_PER_INCH)


def style_of(place: int) -> tuple[str, str]:
    """Return colour and stroke of the n-th series."""
    return SERIES_STYLES[place % len(SERIES_STYLES)]


def trace_figure(named: Sequence[tuple[str, Trace]]) -> Figure:
    """Draw all four parameters over the frames, truth solid and estimate dashed; runs in columns.

    Frames that are lost, and those that show no cable, are shaded. Where the method claims nothing
    the estimate is pale.

    Parameters
    ----------
    named : sequence of (str, Trace)
        Runs with their titles, at least one.
    """
    count = len(named)
    width = 6.2 if count == 1 else 4.4 * count
    with _calm_style():
        figure = Figure(figsize=(width, 4.7))
        grid = figure.subplots(POSE_SIZE, count, sharex="col", squeeze=False)
        for axes, (title, trace) in zip(grid.T, named, strict=True):
            _draw_trace(list(axes), trace)
            axes[0].set_title(title, fontsize=8.5)
        _legend_above(figure, grid[0])
        figure.align_ylabels(list(grid[:, 0]))
        figure.subplots_adjust(
            left=0.62 / width, right=0.99, top=0.9 if count > 1 else 0.935, bottom=0.085,
            hspace=0.14, wspace=0.16,
        )  # fmt: skip
    return figure


def _legend_entries(axes: Iterable[Axes]) -> Iterable[tuple[str, Artist]]:
    for axis in axes:
        handles, labels = axis.get_legend_handles_labels()
        yield from zip(labels, handles, strict=True)


def _draw_trace(axes: Sequence[Axes], trace: Trace) -> None:
    for column, axis in enumerate(axes):
        _shade(axis, trace, trace.hidden, (*to_unit(GREY), 0.35), "no cable to be seen")
        _shade(axis, trace, carried(trace, trace.lost), (*to_unit(RED), 0.22), "lost")
        _draw_component(axis, trace, column)
    axes[-1].set_xlabel("frame")
    axes[-1].set_xlim(trace.frames[0], max(trace.frames[-1], trace.frames[0] + 1))


def _draw_component(axis: Axes, trace: Trace, column: int) -> None:
    _, symbol, unit, factor = POSE_COMPONENTS[column]
    angle = ANGLE
    frames = trace.frames.astype(np.float64)
    truth, estimate = trace.truths[:, column] * factor, trace.estimates[:, column] * factor
    # Labels of every second frame are joined; a cable that was away is not.
    joined = np.isfinite(trace.truths[:, angle]) | trace.hidden
    places, shown = broken_at_wraps(frames[joined], trace.truths[joined, angle], truth[joined])
    draw_line(axis, places, shown, "0.1", lw=1.1, label="truth")
    claims = trace.claimed
    pale, firm = np.where(claims, np.nan, estimate), np.where(claims, estimate, np.nan)
    places, pale, firm = broken_at_wraps(frames, trace.estimates[:, angle], pale, firm)
    dashes = (0, (3.5, 1.8))
    draw_line(axis, places, pale, "0.55", lw=0.9, linestyle=dashes, label="estimate, not claimed")
    green = tuple(0.7 * channel for channel in to_unit(ESTIMATE))
    draw_line(axis, places, firm, green, lw=1.3, linestyle=dashes, label="estimate, claimed")
    axis.set_ylabel(f"{symbol} [{unit}]")
    held = np.where(trace.lost | ~claims, np.nan, estimate)
    axis.set_ylim(_limits(truth, held, SMALLEST_SPANS[column]))
    with_faint_grid(axis)


def _limits(truth: FloatArray, held: FloatArray, smallest: float) -> tuple[float, float]:
    """Return limits that show the truth and the estimates that belong to it; not the lost ones."""
    values = np.concatenate((truth, held))
    finite = values[np.isfinite(values)]
    if not finite.size:
        return -smallest, smallest
    low, high = float(finite.min()), float(finite.max())
    margin = max(0.12 * (high - low), (smallest - (high - low)) / 2)
    return low - margin, high + margin


def carried(trace: Trace, mask: BoolArray) -> BoolArray:
    """Carry what is known of a frame on to those of its recording after it that are not judged."""
    judged = trace.visible | trace.hidden
    judged[[start for start, _ in trace.recordings]] = True
    last = np.maximum.accumulate(np.where(judged, np.arange(len(trace)), 0))
    return mask[last]


def _shade(
    axis: Axes, trace: Trace, mask: BoolArray, colour: tuple[float, ...], label: str
) -> None:
    """Shade the marked frames in a colour with opacity."""
    for number, (start, end) in enumerate(true_runs(mask)):
        axis.axvspan(
            trace.frames[start] - 0.5,
            trace.frames[end - 1] + 0.5,
            color=colour,
            linewidth=0,
            label=label if number == 0 else None,
        )


def _legend_above(figure: Figure, axes: Iterable[Axes]) -> None:
    entries = dict(_legend_entries(axes))
    figure.legend(
        list(entries.values()), list(entries), loc="upper center", ncol=len(entries),
        frameon=False, fontsize=7.5,
    )  # fmt: skip


def loss_figure(results: Sequence[RunResult]) -> Figure:
    """Draw for each method when it has lost the cable: the share of seeds, frame by frame.

    Parameters
    ----------
    results : sequence of RunResult
        Runs on one sequence.
    """
    methods = methods_of(results)
    traces = [result.trace for result in results]
    first = min(int(trace.frames[0]) for trace in traces)
    last = max(int(trace.frames[-1]) for trace in traces)
    shares = _loss_shares(results, methods, (first, last))
    with _calm_style():
        figure = Figure(figsize=(7.2, 0.62 + 0.24 * len(methods)))
        axis = figure.subplots()
        extent = (first - 0.5, last + 0.5, len(methods) - 0.5, -0.5)
        axis.set_facecolor("0.8")
        picture = axis.imshow(
            shares,
            cmap=LOSS_COLOURS,
            vmin=0.0,
            vmax=100.0,
            aspect="auto",
            interpolation="nearest",
            extent=extent,
        )
        axis.set_yticks(range(len(methods)), methods)
        axis.set_yticks(np.arange(len(methods) - 1) + 0.5, minor=True)
        axis.grid(axis="y", which="minor", color="white", linewidth=2.5)
        axis.tick_params(which="both", length=0)
        axis.set_xlabel("frame")
        bar = figure.colorbar(picture, ax=axis, pad=0.015, aspect=8)
        bar.set_label("runs lost [%]")
        figure.tight_layout(pad=0.4)
    return figure


def _loss_shares(
    results: Sequence[RunResult], methods: Sequence[str], span: tuple[int, int]
) -> FloatArray:
    """Return the share of runs that are lost [%], shape (methods, frames).

    `span`: first and last frame. NaN where the cable is not to be seen, or a frame was left out.
    """
    rows = []
    first, last = span
    for method in methods:
        lost, visible = np.zeros(last + 1 - first), np.zeros(last + 1 - first)
        for result in chosen(results, method=method):
            trace = result.trace
            lost[trace.frames - first] += carried(trace, trace.lost)
            visible[trace.frames - first] += carried(trace, trace.visible)
        rows.append(percentages(lost, visible))
    return np.array(rows)


def calibration_figure(results: Sequence[RunResult]) -> Figure:
    """Draw how often the truth lies inside the interval that should hold it so often."""
    with _calm_style():
        figure = Figure(figsize=(7.2, 2.35))
        axes: list[Axes] = list(figure.subplots(1, 4, sharey=True))
        curves = {
            method: 100.0 * coverage((run.trace for run in chosen(results, method=method)), NOMINAL)
            for method in methods_of(results)
        }
        for column, (axis, shown) in enumerate(zip(axes, POSE_COMPONENTS, strict=True)):
            axis.plot((0, 100), (0, 100), color="0.6", linewidth=0.8, linestyle=(0, (2, 2)))
            for place, (method, curve) in enumerate(curves.items()):
                colour, stroke = style_of(place)
                axis.plot(
                    100 * NOMINAL, curve[:, column], color=colour, linestyle=stroke, label=method
                )
            axis.set_title(shown.greek, fontsize=9)
            axis.set_xlabel("nominal [%]")
            axis.set_xlim(0, 100)
            axis.set_ylim(0, 100)
            axis.set_xticks((0, 50, 100))
            with_faint_grid(axis)
        axes[0].set_ylabel("truth inside [%]")
        _legend_above(figure, axes[:1])
        figure.subplots_adjust(left=0.075, right=0.985, top=0.8, bottom=0.18, wspace=0.12)
    return figure


def curves_figure(
    series: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    *,
    x_label: str,
    y_label: str,
    markers: bool = False,
) -> Figure:
    """Draw named curves, each given as its x and y values, into one panel."""
    with _calm_style():
        figure = Figure(figsize=(5.6, 3.4))
        axis = figure.subplots()
        for place, (name, (x, y)) in enumerate(series.items()):
            _draw_curve(axis, place, name, (x, y), markers=markers)
        axis.set_xlabel(x_label)
        axis.set_ylabel(y_label)
        axis.set_ylim(bottom=0.0)
        axis.set_xlim(left=0.0)
        with_faint_grid(axis)
        axis.legend(frameon=False, fontsize=7.5)
        figure.tight_layout(pad=0.5)
    return figure


def _draw_curve(
    axis: Axes,
    place: int,
    name: str,
    points: tuple[ArrayLike, ArrayLike],
    *,
    markers: bool,
) -> str:
    """Draw one of several named curves, given as its x and y values; returns its colour."""
    colour, stroke = style_of(place)
    x, y = points
    axis.plot(
        x, y, color=colour, linestyle=stroke, marker="o" if markers else "", ms=3.5, label=name
    )
    return colour


def trade_off_figure(
    series: Mapping[str, FloatArray], *, gain: str, prices: Sequence[str]
) -> Figure:
    """Draw what a setting gains against its prices, a panel for each price.

    Parameters
    ----------
    series : mapping of str to FloatArray
        By name of the setting: its values, what each of them gains, and the prices, shape
        (n, 2 + prices). The values are written beside the points.
    gain : str
        Label of what is gained.
    prices : sequence of str
        Label of each price.
    """
    with _calm_style():
        figure = Figure(figsize=(7.2, 3.4))
        axes = figure.subplots(1, len(prices), sharey=True, squeeze=False)[0]
        for column, (axis, price) in enumerate(zip(axes, prices, strict=True), start=2):
            for place, (name, rows) in enumerate(series.items()):
                points = (rows[:, column], rows[:, 1])
                colour = _draw_curve(axis, place, name, points, markers=True)
                for row in rows:
                    axis.annotate(
                        f"{row[0]:g}", (row[column], row[1]), xytext=(3, 3 - 9 * place),
                        textcoords="offset points", fontsize=6.0, color=colour,
                    )  # fmt: skip
            axis.set_xlabel(price)
            axis.margins(0.12)
            axis.set_xlim(left=0.0)
            with_faint_grid(axis)
        axes[0].set_ylabel(gain)
        axes[-1].legend(frameon=False, fontsize=7.5)
        figure.tight_layout(pad=0.5)
    return figure
