import pytest

from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import NoMessages
from cable_tracker.sequences.bags.frame_messages import FrameMessages


def test_messages_that_would_be_forgotten_are_not_made(make_frame):
    output = FrameMessages(NoMessages(), make_frame(0))
    output.write_all({node_topics.STATE: lambda: pytest.fail("made")})
    output.write_overlay(node_topics.OVERLAY, lambda: pytest.fail("drawn"))
