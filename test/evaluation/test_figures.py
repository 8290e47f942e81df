from dataclasses import replace

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.figures import (
    as_png,
    as_svg,
    calibration_figure,
    carried,
    curves_figure,
    loss_figure,
    trace_figure,
    trade_off_figure,
)
from cable_tracker.evaluation.trace import trace_of


def test_a_trace_has_four_panels_with_truth_solid_and_estimate_dashed(trace):
    figure = trace_figure([("", trace("hhhlsxnn"))])
    assert [axis.get_ylabel() for axis in figure.axes] == ["d [px]", "α [deg]", "w [px]", "β [deg]"]
    styles = {line.get_label(): line.get_linestyle() for line in figure.axes[0].lines}
    assert styles["truth"] == "-"
    assert styles["estimate, claimed"] == "--"


def test_a_trace_shows_the_numbers(outcome):
    run = trace_of([outcome(i, error=(float(i), 0.0, 0.0, 0.0)) for i in range(5)])
    lines = {line.get_label(): line for line in trace_figure([("", run)]).axes[0].lines}
    assert lines["truth"].get_ydata().tolist() == [10.0] * 5
    assert lines["estimate, claimed"].get_ydata().tolist() == [10.0, 11.0, 12.0, 13.0, 14.0]


@pytest.mark.parametrize("letters", ["h", "n", "u", "x", "nnnn", "ssss", "hun"])
def test_any_run_can_be_drawn(trace, letters):
    assert as_svg(trace_figure([("", trace(letters))])).startswith("<?xml")


def test_the_same_run_gives_the_same_svg(trace):
    first, second = (as_svg(trace_figure([("", trace("hhlh"))])) for _ in range(2))
    assert first == second


def test_runs_stand_in_columns(trace):
    assert len(trace_figure([("a", trace("hh")), ("b", trace("hl"))]).axes) == 8


def test_loss_is_shown_by_method_and_frame(results):
    figure = loss_figure([result for result in results if result.sequence == "stripe"])
    (picture,) = figure.axes[0].images
    assert picture.get_array().shape == (2, 12)


def test_loss_is_shown_at_the_frames_that_it_happened_in(results):
    few = [each for each in results if each.sequence == "stripe"]
    kept = np.arange(12) % 4 != 1
    few = [replace(each, trace=each.trace.where(kept)) for each in few]
    (picture,) = loss_figure(few).axes[0].images
    shares = picture.get_array()
    assert shares.shape == (2, 12)
    assert (np.ma.getmaskarray(shares) | np.isnan(shares.data))[0].tolist() == [
        not shown for shown in kept
    ]


def test_a_claim_of_a_single_frame_is_a_dot(trace):
    lines = trace_figure([("", trace("ssshsss"))]).axes[0].lines
    (dot,) = (line for line in lines if line.get_marker() == "." and len(line.get_xdata()))
    assert dot.get_xydata().tolist() == [[3.0, 10.0]]


def test_a_wrap_hides_no_frame(outcome):
    truths = [CableState(-10.0, np.deg2rad(a), 40.0) for a in (88.0, 89.5)]
    truths += [CableState(10.0, np.deg2rad(a), 40.0) for a in (-89.0, -87.0)]
    run = trace_of([outcome(i, truth) for i, truth in enumerate(truths)])
    lines = {line.get_label(): line for line in trace_figure([("", run)]).axes[0].lines}
    for label in ("truth", "estimate, claimed"):
        drawn = lines[label].get_xydata()
        assert drawn[np.isfinite(drawn[:, 0]), 0].tolist() == [0.0, 1.0, 2.0, 3.0]
        assert np.flatnonzero(np.isnan(drawn[:, 1])).tolist() == [2]


def test_unknown_frames_are_shown_like_the_one_before(trace):
    run = trace("uhluunuh")
    assert carried(run, run.lost).tolist() == [False, False, True, True, True, False, False, False]


def test_what_is_known_of_a_recording_is_not_carried_into_the_next(trace, apart):
    run = apart(trace("hl"), trace("uu"))
    assert carried(run, run.lost).tolist() == [False, True, False, False]


def test_calibration_has_a_curve_for_each_method(results):
    figure = calibration_figure(results)
    assert [axis.get_title() for axis in figure.axes] == ["d", "α", "w", "β"]
    assert all(len(axis.lines) == 3 for axis in figure.axes)


def test_curves_become_a_picture():
    figure = curves_figure({"a": ([1.0, 2.0], [3.0, 4.0])}, x_label="x", y_label="y")
    picture = cv2.imdecode(np.frombuffer(as_png(figure), np.uint8), cv2.IMREAD_COLOR)
    assert min(picture.shape[:2]) > 300


def test_what_is_gained_stands_over_each_price_with_the_values_beside_it():
    rows = np.array([(0.5, 90.0, 2.0, 8.0), (0.7, 85.0, 1.0, np.nan)])
    figure = trade_off_figure({"threshold": rows}, gain="found", prices=("missed", "false"))
    first, second = figure.axes
    assert [first.get_xlabel(), second.get_xlabel()] == ["missed", "false"]
    assert [text.get_text() for text in first.texts] == ["0.5", "0.7"]
    assert first.get_ylim()[0] > 80.0
    assert cv2.imdecode(np.frombuffer(as_png(figure), np.uint8), cv2.IMREAD_COLOR) is not None
