from __future__ import annotations

from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from cable_tracker.ros.health import tracker_health
from cable_tracker.ros.health.tracker_health import TrackerHealth, is_guidance
from cable_tracker.sequences import node_topics
from cable_tracker.tracking.status import WARMING_UP


def says(health: TrackerHealth, **words: str) -> None:
    entries = [DiagnosticStatus(hardware_id=name, message=word) for name, word in words.items()]
    health.take(DiagnosticArray(status=entries))


def test_a_tracker_is_warm_when_its_diagnostics_say_so() -> None:
    health = TrackerHealth()
    assert not health.is_warm()
    says(health, port=WARMING_UP)
    assert not health.is_warm()
    says(health, port="INITIALISING")
    assert health.is_warm()


def test_those_warm_up_that_say_so_until_they_say_something_else() -> None:
    health = TrackerHealth()
    says(health, port=WARMING_UP, starboard=WARMING_UP, pump="OK")
    assert health.warming() == ["port", "starboard"]
    says(health, port="TRACKING")
    assert health.warming() == ["starboard"]
    assert not health.is_warm()


def test_a_tracker_that_has_fallen_silent_is_not_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    health = TrackerHealth()
    says(health, port=WARMING_UP)
    monkeypatch.setattr(tracker_health, "HOLDS", -1.0)
    assert health.warming() == []


def test_the_latest_status_of_a_tracker_is_known_with_its_age() -> None:
    health = TrackerHealth()
    assert health.status("port") == ""
    assert health.age("port") > 1e9
    says(health, port="LOST", starboard="TRACKING")
    assert health.status("port") == "LOST"
    assert 0.0 <= health.age("port") < 300.0


def test_diagnostics_of_a_controller_are_not_those_of_its_tracker() -> None:
    health = TrackerHealth()
    says(health, port=WARMING_UP)
    mode = DiagnosticStatus(name="/x/controller: guidance", hardware_id="port", message="WAITING")
    health.take(DiagnosticArray(status=[mode]))
    assert health.warming() == ["port"]


def test_readers_are_counted_by_the_last_part_of_a_topic() -> None:
    health = TrackerHealth()
    counts = {"subscribers of /x/state": "2", "subscribers of /x/cross_track": "1"}
    values = [KeyValue(key=key, value=value) for key, value in counts.items()]
    health.take(DiagnosticArray(status=[DiagnosticStatus(values=values)]))
    assert health.has_readers(1, node_topics.STATE, node_topics.CROSS_TRACK)
    assert not health.has_readers(2, node_topics.STATE, node_topics.CROSS_TRACK)
    assert not health.has_readers(1, node_topics.CENTRELINE)


@pytest.mark.parametrize(
    ("name", "is_one"), [("/x/controller: guidance", True), ("tracker", False)]
)
def test_guidance_speaks_of_the_controller(name: str, is_one: bool) -> None:
    assert is_guidance(SimpleNamespace(name=name)) is is_one
