from __future__ import annotations

from message_parts import FACTORY

from cable_tracker.sequences.messages.frame_report import fact_number, make_report, report_facts
from cable_tracker.sequences.messages.headers import make_header


def test_facts_are_read_back_by_their_names(sent):
    facts = {"ms": "1.5", "event": "", "hypotheses": "0.9 0.1"}
    report = sent(make_report(FACTORY, make_header(FACTORY, 5, "camera"), "LOST", facts))
    assert report_facts(report) == facts
    assert report.status[0].message == "LOST"


def test_a_number_may_be_empty_or_missing():
    assert fact_number({"ms": "1.5"}, "ms") == 1.5
    assert fact_number({"ms": ""}, "ms") is None
    assert fact_number({}, "ms") is None
