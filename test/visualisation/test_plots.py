from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import OutputError
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.visualisation import plots
from cable_tracker.visualisation.plots import (
    DOTS_PER_INCH,
    broken_at_wraps,
    draw_line,
    figure_png,
    plot_estimates,
    with_faint_grid,
    write_figure,
)

SIGMA = (1.0, 0.01, 1.0, 0.005)


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


def _rows(states, status="TRACKING", step=40_000_000):
    return [
        EstimateRow(index, 5_000_000_000 + index * step, status, state, SIGMA if state else None)
        for index, state in enumerate(states)
    ]


def _swaying(count):
    return [CableState(20 * np.sin(k / 9), 0.3 * np.sin(k / 7), 36.0, 0.03) for k in range(count)]


def _axes(rows, truths=None):
    return plots._draw(plots._series(rows, truths or {})).axes


def _line(axis, number=0):
    return axis.lines[number].get_xydata()


def test_a_picture_is_written(tmp_path):
    path = tmp_path / "estimates.png"
    states = _swaying(60)
    plot_estimates(path, _rows(states), dict(enumerate(states)))
    picture = cv2.imread(str(path))
    assert min(picture.shape[:2]) > 500
    assert picture.std() > 5
    assert [entry.name for entry in tmp_path.iterdir()] == ["estimates.png"]


def test_panels_are_in_pixels_and_degrees_over_seconds():
    states = _swaying(50)
    axes = _axes(_rows(states))
    assert [axis.get_ylabel() for axis in axes] == [
        "d [px]", "alpha [deg]", "w [px]", "beta [deg]",
    ]  # fmt: skip
    np.testing.assert_allclose(_line(axes[0])[:, 0], np.arange(50) * 0.04, atol=1e-12)
    np.testing.assert_allclose(_line(axes[0])[:, 1], [s.distance for s in states])
    np.testing.assert_allclose(_line(axes[1])[:, 1], np.rad2deg([s.angle for s in states]))
    np.testing.assert_allclose(_line(axes[3])[:, 1], np.rad2deg([s.skew for s in states]))


def test_presence_has_a_panel_in_percent_where_it_is_known():
    rows = [replace(row, presence=0.01 * row.frame) for row in _rows(_swaying(5))]
    rows[2] = replace(rows[2], presence=None)
    axes = _axes(rows)
    assert len(axes) == 5
    assert axes[4].get_ylabel() == "presence [%]"
    np.testing.assert_allclose(_line(axes[4])[:, 1], [0.0, 1.0, np.nan, 3.0, 4.0])


def test_a_wrap_draws_no_line_across_the_panel():
    angles = np.deg2rad([88, 89, 90, -89, -88, -87])
    states = [CableState(30.0 * np.sign(a), float(a), 36.0, 0.02 * np.sign(a)) for a in angles]
    for axis, largest in zip(_axes(_rows(states)), (1, 2, 1, 1), strict=True):
        assert np.nanmax(np.abs(np.diff(_line(axis)[:, 1]))) < largest + 1e-9


def test_truth_across_the_wrap_lies_beside_the_estimate():
    estimate = CableState(30.0, np.deg2rad(89.5), 36.0, 0.02)
    truth = CableState(-30.0, np.deg2rad(-89.5), 36.0, -0.02)
    axes = _axes(_rows([estimate] * 3), dict.fromkeys(range(3), truth))
    assert _line(axes[0], 2)[:, 1] == pytest.approx([30.0] * 3)
    assert _line(axes[1], 2)[:, 1] == pytest.approx([90.5] * 3)
    assert _line(axes[3], 2)[:, 1] == pytest.approx([np.rad2deg(0.02)] * 3)


def test_frames_without_a_cable_are_gaps():
    states = [*_swaying(5), None, *_swaying(4)]
    assert (
        np.isnan(_line(_axes(_rows(states))[0])[:, 1]).tolist()
        == [False] * 5 + [True] + [False] * 4
    )


def test_an_estimate_without_neighbours_is_a_dot():
    axes = _axes(_rows([None, CableState(5.0, 0.0, 30.0), None]))
    assert _line(axes[0], 1).tolist() == [[0.04, 5.0]]


def test_times_without_a_claim_are_shaded_and_named():
    rows = [*_rows(_swaying(3)), *_rows([None] * 10, "LOST")[3:6]]
    figure = plots._draw(plots._series(rows, {}))
    spans = [c for c in figure.axes[0].collections if isinstance(c, plots.PolyCollection)]
    shaded = np.vstack([p.vertices for c in spans for p in c.get_paths() if len(p.vertices) <= 5])
    assert shaded[:, 0].min() == pytest.approx(0.1)
    assert shaded[:, 0].max() == pytest.approx(0.2)
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "LOST" in named
    assert "REFUSED" not in named


def test_intervals_reach_half_way_to_the_neighbours():
    times = np.array([0.0, 1.0, 2.0, 4.0, 5.0])
    holds = np.array([True, False, True, True, False])
    assert plots._intervals(times, holds) == [(0.0, 0.5), (1.5, 4.5)]


def test_a_pause_is_shaded_for_neither_side_and_no_presence_is_drawn_over_it():
    times = np.array([0.0, 0.04, 0.08, 7.0, 7.04, 7.08])
    (before, after) = plots._intervals(times, np.array([False, True, True, True, True, False]))
    assert before == pytest.approx((0.02, 0.18))
    assert after == pytest.approx((6.9, 7.06))
    rows = [
        replace(row, stamp=round(time * 1e9), presence=0.9)
        for row, time in zip(_rows(_swaying(6)), times, strict=True)
    ]
    line = _line(_axes(rows)[-1])
    assert np.flatnonzero(np.isnan(line[:, 0])).tolist() == [3]


@pytest.mark.parametrize(
    ("truths", "is_named"), [({}, False), ({1: CableState(1.0, 0.0, 30.0)}, True)]
)
def test_the_legend_names_the_truth_only_where_there_is_one(truths, is_named):
    figure = plots._draw(plots._series(_rows(_swaying(5)), truths))
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert ("ground truth" in texts) == is_named


def test_a_huge_band_does_not_hide_the_curve():
    rows = [
        EstimateRow(k, k * 40_000_000, "TRACKING", state, (1e6, 1e3, 1e6, 1e3))
        for k, state in enumerate(_swaying(40))
    ]
    low, high = _axes(rows)[0].get_ylim()
    assert high - low < 120


@pytest.mark.parametrize(
    "states", [[None, None], [CableState(0.0, 0.0, 30.0)], [CableState(1.0, 1.5, 30.0)] * 4]
)
def test_little_or_nothing_is_plotted_too(tmp_path, states):
    plot_estimates(tmp_path / "estimates.png", _rows(states, "INITIALISING"), {})
    assert (tmp_path / "estimates.png").stat().st_size > 1000


def test_equal_and_backward_stamps_are_survived(tmp_path):
    rows = [EstimateRow(k, s, "LOST") for k, s in enumerate((9, 9, 3, 20))]
    plot_estimates(tmp_path / "estimates.png", rows, {})


def test_a_long_recording_is_thinned_out(tmp_path, monkeypatch):
    monkeypatch.setattr(plots, "LARGEST_COUNT", 50)
    seen = []
    monkeypatch.setattr(plots, "_draw", lambda series, draw=plots._draw: (
        seen.append(len(series.times)), draw(series))[1])  # fmt: skip
    plot_estimates(tmp_path / "estimates.png", _rows(_swaying(499)), {})
    assert seen == [50]


def test_no_rows_no_plot(tmp_path):
    with pytest.raises(OutputError, match="no frames to plot"):
        plot_estimates(tmp_path / "estimates.png", [], {})
    assert list(tmp_path.iterdir()) == []


def test_labels_on_every_second_frame_make_one_line_and_long_gaps_break_it():
    times = np.arange(40) * 0.04
    states = np.full((40, 4), np.nan)
    states[0:10:2] = 1.0
    states[30:40:2] = 2.0
    _, bridged = plots._bridged(times, states)
    assert np.isfinite(bridged[:, 0]).tolist() == [True] * 5 + [False] + [True] * 5


def test_a_label_without_neighbours_is_a_dot_like_an_estimate():
    states = _swaying(200)
    rows = _rows([None] * 200)
    sparse = {frame: states[frame] for frame in range(0, 200, 50)}
    axis = _axes(rows, sparse)[0]
    assert any(line.get_marker() not in ("None", "", None) for line in axis.lines)


def test_labels_of_frames_that_are_thinned_out_are_drawn(monkeypatch):
    monkeypatch.setattr(plots, "LARGEST_COUNT", 50)
    states = _swaying(101)
    odd = {frame: states[frame] for frame in range(1, 101, 2)}
    series = plots._series(_rows(states), odd)
    assert len(series.times) <= 51
    assert np.isfinite(series.truths[:, 0]).sum() == 50
