from __future__ import annotations

from typing import Any

import pytest

from cable_tracker.metric.messages import BEARING_KEYS, METRES_KEYS, PLACE_KEYS
from cable_tracker.ros.messages.announced_topics import announced_topics
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.headers import make_header

PICTURES = [node_topics.PARTICLES, node_topics.MARKERS, node_topics.OVERLAY]
TARGET_PICTURES = [node_topics.MARKERS, node_topics.TARGET_OVERLAY]


def report(status: str, **facts: str) -> Any:
    factory = RosbagsMessages()
    return make_report(factory, make_header(factory, 1, "camera"), status, facts)


@pytest.mark.parametrize(
    ("status", "more"),
    [
        ("TRACKING", [*PICTURES, node_topics.CENTRELINE]),
        ("LOST", PICTURES),
        ("INITIALISING", PICTURES),
        ("REFUSED", []),
        ("DISABLED", []),
    ],
)
def test_the_status_tells_what_is_published_about_a_cable(status, more):
    always = [node_topics.STATE, node_topics.FRAME_REPORT]
    assert announced_topics(node_topics.CABLE_TOPICS, report(status, event="")) == always + more


def test_a_cable_in_metres_is_announced():
    metres = dict.fromkeys(METRES_KEYS, "0.5")
    topics = announced_topics(node_topics.CABLE_TOPICS, report("TRACKING", **metres))
    assert topics[-2:] == [node_topics.CROSS_TRACK, node_topics.CROSS_TRACK_AHEAD]


def test_a_frame_without_a_target_has_pictures_only():
    always = [node_topics.STATE, node_topics.TARGET_REPORT]
    assert (
        announced_topics(node_topics.TARGET_TOPICS, report("REFUSED", event="too small")) == always
    )
    nothing = {"particles": "", "box": "", "corners": ""}
    assert (
        announced_topics(node_topics.TARGET_TOPICS, report("INITIALISING", **nothing))
        == always + TARGET_PICTURES
    )
    searched = nothing | {"particles": "500"}
    topics = announced_topics(node_topics.TARGET_TOPICS, report("LOST", **searched))
    assert topics == [*always, *TARGET_PICTURES, node_topics.PARTICLES]


def test_every_topic_of_a_fully_known_target_is_announced():
    facts = {"particles": "500", "box": "1.0 2.0 30.0 40.0", "corners": "12"}
    facts |= dict.fromkeys((*BEARING_KEYS, *PLACE_KEYS), "0.5")
    assert set(announced_topics(node_topics.TARGET_TOPICS, report("TRACKING", **facts))) == {
        node_topics.STATE,
        node_topics.TARGET_REPORT,
        *TARGET_PICTURES,
        node_topics.PARTICLES,
        node_topics.TARGET,
        node_topics.BOX,
        node_topics.CONTOUR,
        node_topics.BEARING,
        node_topics.RELATIVE_POSE,
    }
