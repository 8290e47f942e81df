from __future__ import annotations

import pytest

from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.rosbags_messages import RosbagsMessages

FACTORY = RosbagsMessages()


@pytest.mark.parametrize("stamp", [0, 1, 999_999_999, 1_000_000_000, 1_700_000_000_123_456_789])
def test_stamps_are_kept_to_the_nanosecond(stamp, sent):
    header = sent(make_header(FACTORY, stamp, "eye"))
    assert stamp_of(header) == stamp
    assert header.frame_id == "eye"
