from types import SimpleNamespace

import pytest

from cable_tracker.metric.recorded.recorded_instruments import (
    LOOK_AHEAD,
    LOOK_BACK,
    InstrumentFeed,
)

SECOND = 1_000_000_000


class Bag:
    """Messages that were received every 100 ms for ten seconds."""

    def __init__(self):
        self.begins = []

    def messages(self, _pauses, begin):
        self.begins.append(begin)
        for received in range(0, 10 * SECOND, SECOND // 10):
            if received >= begin:
                yield SimpleNamespace(received=received)


def frame(seconds):
    received = None if seconds is None else round(seconds * SECOND)
    return SimpleNamespace(received=received)


def received(feed, seconds):
    return [each.received for each in feed.up_to(frame(seconds))]


@pytest.fixture
def bag():
    return Bag()


def test_each_message_is_handed_out_once_up_to_shortly_after_the_frame(bag):
    feed = InstrumentFeed(bag)
    first, second = received(feed, 1.0), received(feed, 2.0)
    assert first[0] == 0
    assert first[-1] <= SECOND + LOOK_AHEAD < second[0]
    assert second[-1] <= 2 * SECOND + LOOK_AHEAD


def test_a_frame_received_at_an_unknown_time_has_no_messages(bag):
    assert received(InstrumentFeed(bag), None) == []


def test_after_a_jump_only_what_is_shortly_before_the_frame_counts(bag):
    feed = InstrumentFeed(bag)
    received(feed, 1.0)
    feed.jump()
    assert received(feed, 6.0)[0] == 6 * SECOND - LOOK_BACK


def test_a_jump_to_the_start_hands_out_all_again(bag):
    feed = InstrumentFeed(bag)
    before = received(feed, 3.0)
    feed.jump(to_start=True)
    assert received(feed, 3.0) == before


def test_a_copy_goes_on_from_here(bag):
    feed = InstrumentFeed(bag)
    received(feed, 1.0)
    copy = feed.copy()
    expected = received(feed, 2.0)
    assert received(copy, 2.0) == expected
    assert bag.begins[1] == SECOND + LOOK_AHEAD + 1


def test_a_recording_without_instruments_has_no_messages():
    assert received(InstrumentFeed(None), 1.0) == []


def test_a_closed_feed_has_none(bag):
    feed = InstrumentFeed(bag)
    feed.close()
    assert received(feed, 1.0) == []
