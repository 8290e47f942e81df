from __future__ import annotations

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure

from cable_tracker.errors import OutputError
from cable_tracker.visualisation.figure_files import (
    DOTS_PER_INCH,
    broken_at_wraps,
    draw_line,
    figure_png,
    with_faint_grid,
    write_figure,
)


@pytest.fixture
def figure():
    figure = Figure(figsize=(2.0, 1.0))
    figure.subplots().plot([0.0, 1.0], [0.0, 1.0])
    return figure


def size_of(content: bytes) -> tuple[int, int]:
    height, width = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE).shape
    return width, height


@pytest.mark.parametrize("resolution", [50, 130])
def test_a_figure_has_the_resolution_that_is_asked_for(figure, resolution):
    assert size_of(figure_png(figure, resolution)) == (2 * resolution, resolution)


def test_a_figure_is_written_as_a_file(figure, tmp_path):
    path = tmp_path / "figure.png"
    write_figure(path, figure)
    assert size_of(path.read_bytes()) == (2 * DOTS_PER_INCH, DOTS_PER_INCH)


def test_a_figure_that_cannot_be_written_leaves_no_file(figure, tmp_path):
    with pytest.raises(OutputError, match="cannot be written"):
        write_figure(tmp_path / "missing" / "figure.png", figure)
    assert not list(tmp_path.iterdir())


def test_a_faint_grid_leaves_two_sides_open(figure):
    axis = figure.axes[0]
    with_faint_grid(axis)
    visible = {side for side, spine in axis.spines.items() if spine.get_visible()}
    assert visible == {"left", "bottom"}
    assert axis.get_xgridlines()[0].get_visible()


def test_what_wraps_is_broken_between_two_values_and_loses_none():
    angles = np.deg2rad([88.0, 89.0, -89.0])
    places, values = broken_at_wraps(np.arange(3.0), angles, np.array([5.0, 6.0, -6.0]))
    np.testing.assert_array_equal(places, [0.0, 1.0, np.nan, 2.0])
    np.testing.assert_array_equal(values, [5.0, 6.0, np.nan, -6.0])


def test_values_without_neighbours_are_dots():
    axis = Figure().subplots()
    draw_line(axis, np.arange(6.0), np.array([1.0, np.nan, 3.0, 4.0, np.nan, 6.0]), "0.5")
    line, dots = axis.lines
    assert len(line.get_xdata()) == 6
    assert dots.get_xdata().tolist() == [0.0, 5.0]
