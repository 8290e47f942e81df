"""Plots of a closed loop: the vehicle's trajectory over the cable, and its error over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.evaluation.loop_table import LoopRow
from cable_tracker.metric.frames import rotation_in_plane
from cable_tracker.simulation.rendering.laid_cable import Stretch
from cable_tracker.visualisation.palette import (
    AMBER,
    BLACK,
    ESTIMATE,
    PINK,
    RED,
    SKY,
    STRAW,
    WHITE,
    Colour,
    dark,
    to_bgr,
)
from cable_tracker.visualisation.plots import write_figure

MODE_COLOURS: dict[str, Colour] = {
    "WAITING": AMBER,
    "STOPPED": SKY,
    "SEARCHING": RED,
    "GIVEN UP": BLACK,
}
"""Colours of the shading of each mode in which the controller follows nothing."""

SAND = "0.85"
"""Shades the stretch under sand."""

FONT = cv2.FONT_HERSHEY_SIMPLEX

PANEL_SIZE = (320, 360)
"""Width and height of the map [px]."""

MAP_REACH = 4.0
"""Distance that the map shows to each side of the vehicle [m]."""


def plot_way(
    path: Path, rows: Sequence[LoopRow], course: FloatArray, burial: Stretch | None
) -> None:
    """Plot the vehicle's trajectory and the cable's course from above.

    Parameters
    ----------
    course : FloatArray
        Points of the cable, shape (N, 3) [m].

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    figure = Figure(figsize=(11.0, 4.2))
    axis = figure.subplots()
    if burial is not None:
        axis.axvspan(burial.start, burial.end, color=SAND, alpha=0.8, lw=0, label="sand")
    axis.plot(course[:, 0], course[:, 1], color="0.25", lw=3.0, alpha=0.5, label="cable")
    x, y = _column(rows, "x"), _column(rows, "y")
    axis.plot(x, y, color=dark(ESTIMATE), lw=1.4, label="vehicle")
    for mode, colour in MODE_COLOURS.items():
        chosen = np.array([row.mode == mode for row in rows])
        if chosen.any():
            axis.plot(x[chosen], y[chosen], ".", ms=4, color=dark(colour), label=mode)
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m], stretched")
    axis.grid(alpha=0.3)
    axis.legend(loc="upper right", ncol=6, frameon=False)
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.2 * (high - low))
    figure.subplots_adjust(left=0.07, right=0.985, top=0.97, bottom=0.12)
    write_figure(path, figure)


def plot_errors(path: Path, rows: Sequence[LoopRow], burial: Stretch | None) -> None:
    """Plot the lateral error, as it was and as `cross_track` said, heading error, and speed.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    figure = Figure(figsize=(11.0, 6.6))
    axes: list[Axes] = list(figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1)))
    times = _column(rows, "time")
    for axis in axes:
        _shade(axis, rows, burial)
        axis.grid(alpha=0.3)
    top, middle, bottom = axes
    top.plot(times, _column(rows, "measured_offset"), ".", ms=2.5, color=dark(SKY),
             label="cross_track")  # fmt: skip
    top.plot(times, _column(rows, "error"), color=dark(PINK), lw=1.5, label="true error")
    top.set_ylabel("lateral error [m]")
    degrees = np.degrees(_column(rows, "measured_heading"))
    middle.plot(times, degrees, ".", ms=2.5, color=dark(SKY))
    middle.plot(times, np.degrees(_column(rows, "heading")), color=dark(PINK), lw=1.2)
    middle.set_ylabel("heading error [deg]")
    bottom.plot(times, _column(rows, "speed"), color=dark(ESTIMATE), lw=1.2)
    bottom.set_ylabel("speed [m/s]")
    bottom.set_xlabel("time since the first frame [s]")
    figure.legend(loc="upper center", ncol=8, frameon=False)
    figure.align_ylabels(axes)
    figure.subplots_adjust(left=0.08, right=0.985, top=0.94, bottom=0.075, hspace=0.12)
    write_figure(path, figure)


def _shade(axis: Axes, rows: Sequence[LoopRow], burial: Stretch | None) -> None:
    times = _column(rows, "time")
    if burial is not None:
        inside = np.flatnonzero(burial.holds(_column(rows, "x")))
        if inside.size:
            label = "above sand" if axis.get_subplotspec().rowspan.start == 0 else None  # type: ignore[union-attr]
            axis.axvspan(times[inside[0]], times[inside[-1]], color=SAND, alpha=0.8, lw=0,
                         label=label)  # fmt: skip
    for mode, colour in MODE_COLOURS.items():
        holds = np.array([row.mode == mode for row in rows])
        is_top = axis.get_subplotspec().rowspan.start == 0  # type: ignore[union-attr]
        label = mode if is_top and holds.any() else None
        axis.fill_between(times, 0.0, 1.0, where=holds.tolist(), step="mid", lw=0, alpha=0.25,
                          color=dark(colour), transform=axis.get_xaxis_transform(),
                          label=label)  # fmt: skip


def _column(rows: Sequence[LoopRow], name: str) -> FloatArray:
    return np.array([getattr(row, name) for row in rows], dtype=np.float64)


class MapPanel:
    """Draws the vehicle from above beside the picture of its camera.

    Parameters
    ----------
    course : FloatArray
        Points of the cable, shape (N, 3) [m].
    burial : Stretch or None
        Stretch of the cable under sand.
    """

    def __init__(self, course: FloatArray, burial: Stretch | None) -> None:
        self._course = course
        self._burial = burial
        self._trajectory: list[tuple[float, float]] = []

    def draw(self, place: tuple[float, float], yaw: float, words: Sequence[str]) -> Image:
        """Draw the vehicle at x, y [m] with lines of text; (H, W, 3), blue-green-red, uint8."""
        self._trajectory.append(place)
        width, height = PANEL_SIZE
        canvas: Image = np.full((height, width, 3), 40, dtype=np.uint8)
        centre = np.array(place)
        under = self._course[:, :2]
        if self._burial is not None:
            hidden = self._burial.holds(under[:, 0])
            self._line(canvas, under[~hidden & (under[:, 0] < self._burial.start)], centre, WHITE)
            self._line(canvas, under[~hidden & (under[:, 0] > self._burial.end)], centre, WHITE)
            self._line(canvas, under[hidden], centre, STRAW)
        else:
            self._line(canvas, under, centre, WHITE)
        self._line(canvas, np.array(self._trajectory), centre, ESTIMATE)
        self._vehicle(canvas, yaw)
        for number, line in enumerate(words):
            position = (8, 18 + 16 * number)
            cv2.putText(
                canvas,
                line,
                position,
                FONT,
                0.42,
                to_bgr(WHITE),
                1,
                cv2.LINE_AA,
            )
        return canvas

    def _pixels(self, points: FloatArray, centre: FloatArray) -> Image:
        """Put x up and y to the left, the vehicle in the middle."""
        width, height = PANEL_SIZE
        scale = width / (2 * MAP_REACH)
        relative = np.clip(points - centre, -100.0, 100.0)
        columns = width / 2 - relative[:, 1] * scale
        rows = height * 0.62 - relative[:, 0] * scale
        return np.asarray(np.rint(np.stack((columns, rows), axis=-1)).astype(np.int32))

    def _line(self, canvas: Image, points: FloatArray, centre: FloatArray, colour: Colour) -> None:
        near = points[np.abs(points[:, 0] - centre[0]) < 2.5 * MAP_REACH]
        if len(near) > 1:
            pixels = self._pixels(near, centre)
            cv2.polylines(canvas, [pixels], False, to_bgr(colour), 2, cv2.LINE_AA)

    def _vehicle(self, canvas: Image, yaw: float) -> None:
        hull = np.array([[0.35, 0.0], [-0.25, 0.18], [-0.25, -0.18]])
        # Corners are rows: they are turned by the transposed matrix, which turns back.
        turned = hull @ rotation_in_plane(-yaw)
        pixels = self._pixels(turned, np.zeros(2))
        cv2.fillPoly(canvas, [pixels], to_bgr(SKY), cv2.LINE_AA)
