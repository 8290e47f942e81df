import math

import pytest

from cable_tracker.evaluation.metrics.redetection import cable_returns, return_statistics
from cable_tracker.evaluation.trace import trace_of


def shown(outcome, *pieces):
    """Make a run of pieces: number of frames, visibility, whether the cable is claimed rightly."""
    frames = [(share, right) for count, share, right in pieces for _ in range(count)]
    return trace_of(
        [outcome(i, visibility=share, claimed=right) for i, (share, right) in enumerate(frames)]
    )


def test_a_return_counts_from_when_the_cable_clearly_shows(outcome):
    run = shown(
        outcome, (3, 0.9, True), (5, 0.0, False), (4, 0.2, False), (2, 0.3, False), (40, 0.9, True)
    )
    (back,) = cable_returns(run)
    assert back.start == 12
    assert back.seconds == pytest.approx(0.08)


@pytest.mark.parametrize(("silent", "found"), [(0, 1.0), (25, 1.0), (26, 0.0)])
def test_a_cable_is_found_again_within_a_second(outcome, silent, found):
    run = shown(outcome, (3, 0.9, True), (5, 0.0, False), (silent, 0.9, False), (30, 0.9, True))
    returns = return_statistics(run)
    assert (returns.count, returns.found) == (1.0, found)
    assert returns.seconds == pytest.approx(silent * 0.04 if found else math.nan, nan_ok=True)


def test_a_cable_does_not_come_back_in_another_recording(trace, apart):
    assert cable_returns(apart(trace("hhnn"), trace("s" * 30))) == []
    assert cable_returns(apart(trace("hhnn" + "s" * 10), trace("s" * 30))) == []
    (back,) = cable_returns(apart(trace("hh"), trace("hhnn" + "h" * 30)))
    assert back.start == 6


def test_a_wrong_claim_finds_nothing(trace):
    assert return_statistics(trace("hhnn" + "l" * 30)).found == 0.0


@pytest.mark.parametrize(
    "letters",
    [
        "h" * 60,
        "n" * 10 + "h" * 60,
        "hhnn" + "h" * 25,
        "hhnn" + "s" * 10 + "n" * 30,
        "nnff",
    ],
    ids=["never away", "never seen before", "run ends", "leaves again", "no cable"],
)
def test_without_a_full_return_nothing_is_found_again(trace, letters):
    returns = return_statistics(trace(letters))
    assert returns.count == 0.0
    assert math.isnan(returns.found)


def test_every_return_counts(trace):
    returns = return_statistics(trace("hhnn" + "h" * 30 + "n" + "s" * 30))
    assert (returns.count, returns.found, returns.seconds) == (2.0, 0.5, 0.0)
