from __future__ import annotations

import pytest
from message_parts import FACTORY

from cable_tracker.errors import FrameError
from cable_tracker.sequences.messages.headers import make_header, stamp_of, stamp_or_received

LAST = 2**31 * 10**9 - 1


@pytest.mark.parametrize("stamp", [0, 1, 999_999_999, 1_000_000_000, 1_700_000_000_123_456_789])
def test_stamps_are_kept_to_the_nanosecond(stamp, sent):
    header = sent(make_header(FACTORY, stamp, "eye"))
    assert stamp_of(header) == stamp
    assert header.frame_id == "eye"


@pytest.mark.parametrize("stamp", [-(2**31) * 10**9, LAST])
def test_the_first_and_the_last_time_of_a_message_are_kept(stamp, sent):
    assert stamp_of(sent(make_header(FACTORY, stamp, "eye"))) == stamp


@pytest.mark.parametrize("stamp", [-(2**31) * 10**9 - 1, LAST + 1])
def test_a_time_beyond_them_is_refused(stamp):
    with pytest.raises(FrameError, match="check the clock"):
        make_header(FACTORY, stamp, "eye")


def test_a_message_without_a_stamp_is_of_when_it_was_received():
    stamped, unstamped = (
        FACTORY.make("sensor_msgs/msg/Range", header=make_header(FACTORY, stamp, "eye"))
        for stamp in (7, 0)
    )
    without_header = FACTORY.make("std_msgs/msg/String", data="hello")
    beyond = FACTORY.make("sensor_msgs/msg/Range", header=make_header(FACTORY, LAST, "eye"))
    beyond.header.stamp.nanosec += 1
    each = [stamped, unstamped, without_header, beyond]
    assert [stamp_or_received(message, 9) for message in each] == [7, 9, 9, 9]
