from __future__ import annotations

from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from cable_tracker.ros.health import warming_trackers
from cable_tracker.ros.health.warming_trackers import WarmingTrackers
from cable_tracker.tracking.status import WARMING_UP


def says(trackers: WarmingTrackers, **words: str) -> None:
    entries = [DiagnosticStatus(hardware_id=name, message=word) for name, word in words.items()]
    trackers.on_diagnostics(DiagnosticArray(status=entries))


def test_those_are_known_that_say_so_until_they_say_something_else(world: Any) -> None:
    trackers = WarmingTrackers(world.me)
    says(trackers, port=WARMING_UP, starboard=WARMING_UP, pump="OK")
    assert trackers.names() == ["port", "starboard"]
    says(trackers, port="TRACKING")
    assert trackers.names() == ["starboard"]


def test_one_that_has_fallen_silent_is_not_waited_for(
    world: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    trackers = WarmingTrackers(world.me)
    says(trackers, port=WARMING_UP)
    monkeypatch.setattr(warming_trackers, "HOLDS", -1.0)
    assert trackers.names() == []
