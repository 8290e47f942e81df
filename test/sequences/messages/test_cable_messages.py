from __future__ import annotations

from dataclasses import replace

import numpy as np
from message_parts import FACTORY, HEADER

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import read_sigma, read_state
from cable_tracker.sequences.messages.cable_messages import cable_messages, messages_without_cable
from cable_tracker.sequences.messages.frame_report import report_facts, report_status
from cable_tracker.tracking.status import TrackingStatus

STATE = CableState(12.5, 0.3, 40.0, 0.02)
ESTIMATE = CableEstimate(
    stamp=1_700_000_000_123_456_789,
    status=TrackingStatus.TRACKING,
    image_size=(320, 240),
    state=STATE,
    covariance=np.diag([4.0, 0.01, 9.0, 0.0001, 1.0, 1.0, 1.0, 1.0]),
    hypotheses=(),
    effective_sample_size=5.0,
    evidence=1.0,
)
PARTICLES = Particles(np.zeros((5, 8)), np.full(5, 0.2))


def makers_of(estimate, particles=PARTICLES):
    return cable_messages(
        FACTORY, HEADER, estimate, particles, ms=3.5, metres=lambda: {"offset": "0.5"}
    )


def test_each_message_of_a_claimed_cable_has_the_type_of_its_topic():
    makers = makers_of(ESTIMATE)
    assert set(makers) == {
        node_topics.STATE,
        node_topics.FRAME_REPORT,
        node_topics.CENTRELINE,
        node_topics.PARTICLES,
        node_topics.MARKERS,
    }
    assert all(make().__msgtype__ == topic.type_name for topic, make in makers.items())
    state = makers[node_topics.STATE]()
    assert read_state(state) == STATE
    assert read_sigma(state) == (2.0, 0.1, 3.0, 0.01)


def test_a_cable_that_is_not_claimed_has_no_centreline():
    makers = makers_of(replace(ESTIMATE, status=TrackingStatus.LOST))
    assert node_topics.CENTRELINE not in makers
    assert read_state(makers[node_topics.STATE]()) is None


def test_without_particles_there_is_no_message_of_them():
    assert node_topics.PARTICLES not in makers_of(ESTIMATE, None)


def test_metres_are_asked_for_when_the_report_is_made():
    asked = []
    makers = cable_messages(
        FACTORY, HEADER, ESTIMATE, None, ms=3.5, metres=lambda: asked.append(1) or {"offset": "0.5"}
    )
    assert asked == []
    facts = report_facts(makers[node_topics.FRAME_REPORT]())
    assert (facts["ms"], facts["offset"]) == ("3.5", "0.5")
    assert asked == [1]


def test_a_refused_frame_has_an_empty_state_and_a_reason():
    makers = messages_without_cable(FACTORY, HEADER, "REFUSED", "too small")
    assert read_state(makers[node_topics.STATE]()) is None
    report = makers[node_topics.FRAME_REPORT]()
    assert (report_status(report), report_facts(report)) == ("REFUSED", {"event": "too small"})
