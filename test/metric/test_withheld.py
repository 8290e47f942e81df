import pytest

from cable_tracker.metric.withheld import Reason, Withheld, newly_withheld

STALE = Withheld(Reason.STALE_ALTITUDE, "for 2 s")


def test_a_result_is_no_news():
    assert newly_withheld(STALE, "a result") is None


@pytest.mark.parametrize("reason", [Reason.NOT_TRACKING, Reason.NO_TARGET])
def test_that_nothing_is_claimed_is_said_elsewhere(reason):
    assert newly_withheld("a result", Withheld(reason, "")) is None


def test_a_reason_is_news_once_in_whatever_words():
    assert newly_withheld(None, STALE) is STALE
    assert newly_withheld("a result", STALE) is STALE
    assert newly_withheld(Withheld(Reason.NO_ALTITUDE, ""), STALE) is STALE
    assert newly_withheld(Withheld(Reason.STALE_ALTITUDE, "for 1 s"), STALE) is None
