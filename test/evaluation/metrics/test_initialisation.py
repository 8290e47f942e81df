import math

import pytest

from cable_tracker.evaluation.metrics.initialisation import StartOutcome, start_statistics
from cable_tracker.evaluation.trace import trace_of


@pytest.mark.parametrize(
    ("letters", "outcome", "frames"),
    [
        ("sshh", StartOutcome.RIGHT, 3),
        ("sslh", StartOutcome.RIGHT, 4),
        ("sl" + "x" * 28 + "h", StartOutcome.WRONG, 31),
        ("nnnhh", StartOutcome.RIGHT, 1),
        ("s" * 30 + "h", StartOutcome.NONE, 31),
        ("s" * 29 + "h", StartOutcome.RIGHT, 30),
        ("nn", None, math.nan),
    ],
)
def test_a_start_is_right_if_the_cable_is_claimed_within_30_frames_that_show_it(
    trace, letters, outcome, frames
):
    start = start_statistics(trace(letters))
    assert start.outcome is outcome
    assert start.frames_to_right == pytest.approx(frames, nan_ok=True)


def test_a_start_is_as_clear_as_the_frames_that_it_is_judged_by(outcome):
    shares = [0.0, 0.0, *[0.4, 0.8] * 15, *[1.0] * 5]
    run = trace_of([outcome(i, visibility=share) for i, share in enumerate(shares)])
    assert start_statistics(run).visibility == pytest.approx(0.6)
