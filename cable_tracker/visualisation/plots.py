"""Plots of the estimates of a whole recording over time, and what figures have in common."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, true_runs
from cable_tracker.atomic_output import write_bytes
from cable_tracker.cable.model.geometry import wrap_state, wraps_between
from cable_tracker.cable.model.state import ANGLE, POSE_COMPONENTS, POSE_SIZE, CableState
from cable_tracker.errors import OutputError
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.tracking.status import REFUSED, TrackingStatus
from cable_tracker.visualisation.palette import ESTIMATE, TRUTH, dark, status_colour

DOTS_PER_INCH = 110

LARGEST_COUNT = 10_000
"""A longer recording is thinned out to at most this many frames: a plot cannot show more."""

SHADED_STATUSES = (TrackingStatus.INITIALISING.value, TrackingStatus.LOST.value, REFUSED)

LONGEST_BRIDGE = 0.5
"""Longest time without a label that the line of the truth runs across [s]."""

LONGEST_STEP = 5.0
"""Time between two frames from which on it is a pause [median of these times]."""

PANEL_HEIGHT = 2.1
"""[inch]."""


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


@dataclass(frozen=True, slots=True, eq=False)
class _Series:
    """The table as arrays; NaN where there is no value.

    Attributes
    ----------
    times : FloatArray
        Times since the first stamp, shape (T,) [s].
    estimates, sigmas : FloatArray
        d, alpha, w, beta, shape (T, 4) [px, rad].
    true_times : FloatArray
        Times of the truths, shape (S,) [s]; NaN within a long stretch without labels.
    truths : FloatArray
        d, alpha, w, beta of the truth, shape (S, 4) [px, rad].
    presence : FloatArray
        Probability that a cable is in view, shape (T,).
    statuses : tuple of str
        Length T.
    """

    times: FloatArray
    estimates: FloatArray
    sigmas: FloatArray
    true_times: FloatArray
    truths: FloatArray
    presence: FloatArray
    statuses: tuple[str, ...]


def plot_estimates(
    path: Path, rows: Sequence[EstimateRow], truths: Mapping[int, CableState]
) -> None:
    """Plot d, alpha, w and beta over time, with bands of two sigma, and the truth where known.

    Where the filter knows the probability that a cable is in view, a panel below shows it.

    Parameters
    ----------
    path : Path
        PNG file to write; a failure leaves no file behind.
    rows : sequence of EstimateRow
        One for each frame.
    truths : mapping of int to CableState
        Truth by number of the frame; may be empty.

    Raises
    ------
    OutputError
        There are no rows, or the file cannot be written.
    """
    if not rows:
        raise OutputError(f"{path}: there are no frames to plot; check the recording")
    figure = _draw(_series(rows, truths))
    write_figure(path, figure)


def _series(rows: Sequence[EstimateRow], truths: Mapping[int, CableState]) -> _Series:
    first = rows[0].stamp
    times = np.array([(row.stamp - first) / NANOSECONDS for row in rows])
    true_times, true = _bridged(times, _truths_of(rows, truths))
    # Each by itself: a label of one frame in many is not left out because its frame is.
    thinned = -(-len(true) // LARGEST_COUNT) if len(true) else 1
    true_times, true = true_times[::thinned], true[::thinned]
    shown = slice(None, None, -(-len(rows) // LARGEST_COUNT))
    rows, times = rows[shown], times[shown]
    estimates, sigmas = (np.full((len(rows), 4), np.nan) for _ in range(2))
    for index, row in enumerate(rows):
        if row.state is not None:
            estimates[index] = row.state.to_array()[:4]
            if row.sigma is not None:
                sigmas[index] = row.sigma
    presence = np.array([np.nan if row.presence is None else row.presence for row in rows])
    statuses = tuple(row.status for row in rows)
    return _Series(times, estimates, sigmas, true_times, true, presence, statuses)


def _truths_of(rows: Sequence[EstimateRow], truths: Mapping[int, CableState]) -> FloatArray:
    """Return d, alpha, w, beta of the truth of each row, shape (T, 4); NaN without a label."""
    found = np.full((len(rows), 4), np.nan)
    for index, row in enumerate(rows):
        truth = truths.get(row.frame)
        if truth is not None:
            found[index] = _in_chart(truth, row.state)
    return found


def _in_chart(truth: CableState, estimate: CableState | None) -> FloatArray:
    """Return d, alpha, w, beta of the truth, on the same side of the wrap as the estimate."""
    values = truth.to_array()
    if estimate is not None and estimate.is_finite():
        values = wrap_state(values, estimate.angle)
    return values[:4]


def _draw(series: _Series) -> Figure:
    knows_presence = bool(np.isfinite(series.presence).any())
    count = POSE_SIZE + knows_presence
    figure = Figure(figsize=(11.0, 0.1 + PANEL_HEIGHT * count))
    axes: list[Axes] = list(figure.subplots(count, 1, sharex=True))
    low, high = float(series.times.min()), float(series.times.max())
    shaded = [status for status in SHADED_STATUSES if status in series.statuses]
    for axis in axes:
        for status in shaded:
            _shade(axis, series, status)
    for column, axis in enumerate(axes[:POSE_SIZE]):
        _draw_component(axis, series, column)
    if knows_presence:
        _draw_presence(axes[-1], series)
    axes[-1].set_xlim(low, high if high > low else low + 1.0)
    axes[-1].set_xlabel("time since the first frame [s]")
    _add_legend(figure, series, shaded)
    figure.align_ylabels(axes)
    figure.subplots_adjust(left=0.085, right=0.985, top=0.94, bottom=0.065, hspace=0.12)
    return figure


def _draw_component(axis: Axes, series: _Series, column: int) -> None:
    shown = POSE_COMPONENTS[column]
    estimates, truths = series.estimates, series.truths
    times, estimate, sigma = broken_at_wraps(
        series.times,
        estimates[:, ANGLE],
        estimates[:, column] * shown.factor,
        series.sigmas[:, column] * shown.factor,
    )
    colour = dark(ESTIMATE)
    axis.fill_between(
        times, estimate - 2 * sigma, estimate + 2 * sigma, color=colour, alpha=0.25, linewidth=0
    )
    draw_line(axis, times, estimate, colour, linewidth=1.4)
    true_times, truth = broken_at_wraps(
        series.true_times, truths[:, ANGLE], truths[:, column] * shown.factor
    )
    draw_line(axis, true_times, truth, dark(TRUTH), linewidth=1.3, linestyle=(0, (4, 2)))
    axis.set_ylim(_limits(np.concatenate((estimate, truth)), sigma))
    axis.set_ylabel(shown.heading)
    with_faint_grid(axis)


def _draw_presence(axis: Axes, series: _Series) -> None:
    pauses = _pauses(series.times)
    times, percent = (
        np.insert(values, pauses, np.nan) for values in (series.times, 100 * series.presence)
    )
    draw_line(axis, times, percent, dark(ESTIMATE), linewidth=1.4)
    axis.set_ylim(-4, 104)
    axis.set_ylabel("presence [%]")
    with_faint_grid(axis)


def _bridged(times: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Leave out frames without a label, except in the middle of a long stretch of them.

    Where only every second or third frame is labelled, a line would otherwise never be drawn.
    """
    labelled = np.flatnonzero(np.isfinite(states[:, ANGLE]))
    long_gaps = np.flatnonzero(np.diff(times[labelled]) > LONGEST_BRIDGE)
    kept = np.sort(np.concatenate((labelled, labelled[long_gaps] + 1)))
    return times[kept], states[kept]


def _limits(values: FloatArray, sigma: FloatArray) -> tuple[float, float]:
    """Return limits that show all values, and as much of the band as does not dwarf them."""
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return -1.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    usual = sigma[np.isfinite(sigma)]
    band = 2.2 * float(np.quantile(usual, 0.9)) if usual.size else 0.0
    spread = max(high - low, 1e-3 * max(abs(high), abs(low)), 1e-6)
    margin = 0.06 * spread + min(band, 0.75 * spread)
    return low - margin, high + margin


def _shade(axis: Axes, series: _Series, status: str) -> None:
    """Shade the times at which the status holds, from half-way to half-way between frames."""
    spans = _intervals(series.times, np.array([name == status for name in series.statuses]))
    boxes = [[(a, 0.0), (a, 1.0), (b, 1.0), (b, 0.0)] for a, b in spans]
    collection = PolyCollection(
        boxes,
        facecolors=[(*dark(status_colour(status)), _shade_opacity(status))],
        edgecolors="none",
        transform=axis.get_xaxis_transform(),
        zorder=0.5,
    )
    axis.add_collection(collection, autolim=False)


def _shade_opacity(status: str) -> float:
    return 0.35 if status == REFUSED else 0.25


def _intervals(times: FloatArray, holds: BoolArray) -> list[tuple[float, float]]:
    """Return the spans of time that the marked frames stand for; a pause is part of none."""
    halves = 0.5 * np.minimum(np.diff(times), _longest_step(times))
    begins = times - np.concatenate(([0.0], halves))
    ends = times + np.concatenate((halves, [0.0]))
    pauses = _pauses(times)
    spans = []
    for first, stop in true_runs(holds):
        inside = pauses[(pauses > first) & (pauses < stop)].tolist()
        for begin, end in pairwise((first, *inside, stop)):
            spans.append((float(begins[begin]), float(ends[end - 1])))
    return spans


def _longest_step(times: FloatArray) -> float:
    """Return the time between two frames from which on it is a pause [s]."""
    usual = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    return LONGEST_STEP * usual if usual > 0.0 else math.inf


def _pauses(times: FloatArray) -> IndexArray:
    """Return the frames before which there was a pause."""
    return np.flatnonzero(np.diff(times) > _longest_step(times)) + 1


def _add_legend(figure: Figure, series: _Series, shaded: Sequence[str]) -> None:
    colour = dark(ESTIMATE)
    entries: list[tuple[Line2D | Patch, str]] = [
        (Line2D([], [], color=colour, linewidth=1.6), "estimate"),
        (Patch(color=colour, alpha=0.25, linewidth=0), "estimate ± 2 sigma"),
    ]
    if np.isfinite(series.truths).any():
        line = Line2D([], [], color=dark(TRUTH), linewidth=1.5, linestyle=(0, (4, 2)))
        entries.append((line, "ground truth"))
    for status in shaded:
        patch = Patch(color=dark(status_colour(status)), alpha=_shade_opacity(status), linewidth=0)
        entries.append((patch, status))
    handles, labels = zip(*entries, strict=True)
    figure.legend(list(handles), list(labels), loc="upper center", ncol=len(labels), frameon=False)
