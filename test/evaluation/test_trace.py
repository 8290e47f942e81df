import math

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.trace import trace_of


def test_errors_are_estimate_minus_truth(outcome):
    trace = trace_of([outcome(0, error=(3.0, -0.02, 1.0, 0.005))])
    assert trace.errors[0] == pytest.approx([3.0, -0.02, 1.0, 0.005])


def test_a_line_on_the_other_side_of_the_wrap_is_no_error_and_turns_its_covariance(outcome):
    truth = CableState(20.0, math.pi / 2 - 0.01, 40.0, 0.03)
    first = outcome(0, truth)
    # The same cable, written with its normal turned round: d and beta change their signs.
    turned = CableState(-20.0, -math.pi / 2 - 0.01 + 1e-12, 40.0, -0.03)
    covariance = np.eye(8)
    covariance[0, 1] = covariance[1, 0] = 0.5
    covariance[0, 3] = covariance[3, 0] = 0.25
    estimate = type(first.estimate)(
        first.estimate.stamp, first.estimate.status, turned, covariance, 1.0, 1.0, (320, 240)
    )
    trace = trace_of([type(first)(0, truth, 1.0, estimate, 1.0)])
    assert trace.errors[0] == pytest.approx([0, 0, 0, 0], abs=1e-9)
    assert trace.covariances[0][0, 1] == -0.5
    assert trace.covariances[0][0, 3] == 0.25


@pytest.mark.parametrize(
    ("width", "cable", "error", "lost"),
    [
        (320, 40.0, (19.9, 0.0, 0.0, 0.0), False),
        (1280, 6.0, (39.9, 0.0, 0.0, 0.0), False),
        (320, 6.0, (10.1, 0.0, 0.0, 0.0), True),
        (320, 40.0, (0.0, math.radians(-8.1), 0.0, 0.0), True),
    ],
)
def test_lost_means_off_by_10_px_and_half_the_width_or_by_8_degrees(
    outcome, width, cable, error, lost
):
    trace = trace_of([outcome(0, CableState(0.0, 0.0, cable), error, width=width)])
    assert trace.lost.tolist() == [lost]


def test_silence_is_loss(trace):
    assert trace("lxhs").lost.tolist() == [True, True, False, True]
    assert trace("lxhs").useful.tolist() == [False, False, True, False]


def test_whether_the_mean_is_off_does_not_depend_on_the_claim(trace):
    assert trace("lxhs").off.tolist() == [True, True, False, False]


@pytest.mark.parametrize("letters", ["hlsxfnu", "h", "sx", "fnu", "llhss"])
def test_a_visible_cable_is_either_lost_or_useful(trace, letters):
    run = trace(letters)
    assert (run.useful ^ run.lost == run.visible).all()
    assert not (run.useful & ~run.claimed).any()


def test_frames_are_visible_hidden_or_not_judged(trace):
    run = trace("hfnu")
    assert run.visible.tolist() == [True, False, False, False]
    assert run.hidden.tolist() == [False, True, True, False]
    assert run.claimed.tolist() == [True, True, False, True]
    assert not run.lost[1:].any()


def test_a_cable_that_is_known_but_buried_is_hidden(outcome):
    run = trace_of([outcome(0, visibility=0.0)])
    assert run.hidden.all()
    assert not run.visible.any()


def test_a_part_is_the_run_from_there_to_there(trace):
    part = trace("hhlls").part(2, 4)
    assert part.lost.tolist() == [True, True]
    assert part.frames.tolist() == [2, 3]


def test_frames_of_a_mask_are_taken_with_all_that_is_known_of_them(trace):
    whole = trace("hlsfn")
    part = whole.where(whole.visible & whole.claimed)
    assert part.frames.tolist() == [0, 1]
    assert part.errors[:, 0].tolist() == [0.0, 50.0]
    assert part.covariances.shape == (2, 4, 4)
    assert part.statuses == whole.statuses[:2]
    assert len(whole.where(whole.frames > 9)) == 0


@pytest.fixture
def two_recordings(outcome, apart):
    """A list of a recording of three frames 320 px wide, and one of two frames 1280 px wide."""
    error = (30.0, 0.0, 0.0, 0.0)
    first, second = (
        trace_of([outcome(number, error=error, width=width) for number in range(count)])
        for width, count in ((320, 3), (1280, 2))
    )
    return apart(first, second)


def test_recordings_of_a_list_are_told_apart(trace, two_recordings):
    assert trace("hhh").recordings == [(0, 3)]
    assert two_recordings.recordings == [(0, 3), (3, 5)]


def test_what_is_between_recordings_is_no_part_of_the_duration(two_recordings):
    assert two_recordings.seconds == pytest.approx(0.08 + 0.04)


def test_each_frame_is_judged_by_its_own_width(two_recordings):
    assert two_recordings.off.tolist() == [True, True, True, False, False]
    assert two_recordings.part(3, 5).off.tolist() == [False, False]
