"""Topics on which a tracker publishes about a frame, as its report of the frame announces them.

Topics overtake each other. A reader that puts together what was said of one frame learns here what
there is to wait for.
"""

from __future__ import annotations

from cable_tracker.metric.messages import has_bearing, has_metres, has_position
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_facts, report_status
from cable_tracker.sequences.node_topics import CABLE_TOPICS, NodeTopic, TrackerTopics
from cable_tracker.tracking.status import TrackingStatus

USED = frozenset(status.value for status in TrackingStatus)
"""Statuses of frames that the tracker has used: neither refused, nor let pass while it rests."""


def announced_topics(topics: TrackerTopics, report: Message) -> list[NodeTopic]:
    """Return the topics on which a tracker publishes about a frame, by the frame's report.

    Of several targets those of the first.
    """
    return _cable_topics(report) if topics is CABLE_TOPICS else _target_topics(report)


def _cable_topics(report: Message) -> list[NodeTopic]:
    status = report_status(report)
    topics = [node_topics.STATE, node_topics.FRAME_REPORT]
    if status in USED:
        topics += [node_topics.PARTICLES, node_topics.MARKERS, node_topics.OVERLAY]
    if status == TrackingStatus.TRACKING.value:
        topics.append(node_topics.CENTRELINE)
    if has_metres(report_facts(report)):
        topics += [node_topics.CROSS_TRACK, node_topics.CROSS_TRACK_AHEAD]
    return topics


def _target_topics(report: Message) -> list[NodeTopic]:
    facts = report_facts(report)
    topics = [node_topics.STATE, node_topics.TARGET_REPORT]
    if report_status(report) in USED:
        topics += [node_topics.MARKERS, node_topics.TARGET_OVERLAY]
    if facts.get("particles"):
        topics.append(node_topics.PARTICLES)
    if facts.get("box"):
        topics += [node_topics.TARGET, node_topics.BOX]
    if facts.get("corners"):
        topics.append(node_topics.CONTOUR)
    if has_bearing(facts):
        topics.append(node_topics.BEARING)
    if has_position(facts):
        topics.append(node_topics.RELATIVE_POSE)
    return topics
