from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from message_parts import ESTIMATE, FACTORY, HEADER

from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.frame_report import report_facts, report_status
from cable_tracker.sequences.messages.target_messages import (
    messages_without_target,
    target_messages,
)
from cable_tracker.tracking.status import TrackingStatus

PARTICLES = Particles(np.zeros((5, 6)), np.full(5, 0.2))
ALWAYS = {node_topics.STATE, node_topics.TARGET_REPORT, node_topics.MARKERS}
CLAIMED = {node_topics.TARGET, node_topics.BOX}


def makers_of(estimate, particles=None):
    return target_messages(
        FACTORY, HEADER, estimate, particles, ms=3.5, metres=lambda: {"range": "2.5"}
    )


@pytest.mark.parametrize(
    ("estimate", "particles", "more"),
    [
        (ESTIMATE, PARTICLES, CLAIMED | {node_topics.CONTOUR, node_topics.PARTICLES}),
        (replace(ESTIMATE, outline=np.empty((0, 2))), None, CLAIMED),
        (replace(ESTIMATE, status=TrackingStatus.LOST), None, set()),
        (replace(ESTIMATE, box=None), None, set()),
    ],
)
def test_each_message_that_there_is_has_the_type_of_its_topic(estimate, particles, more):
    makers = makers_of(estimate, particles)
    assert set(makers) == ALWAYS | more
    assert all(make().__msgtype__ == topic.type_name for topic, make in makers.items())


def test_the_report_holds_time_particles_and_metres():
    facts = report_facts(makers_of(ESTIMATE, PARTICLES)[node_topics.TARGET_REPORT]())
    assert (facts["ms"], facts["particles"], facts["range"]) == ("3.5", "5", "2.5")


def test_a_refused_frame_has_an_empty_state_and_a_reason():
    makers = messages_without_target(FACTORY, HEADER, "REFUSED", "too small")
    assert len(makers[node_topics.STATE]().position) == 0
    report = makers[node_topics.TARGET_REPORT]()
    assert (report_status(report), report_facts(report)) == ("REFUSED", {"event": "too small"})
