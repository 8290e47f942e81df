from types import SimpleNamespace

import pytest

from cable_tracker.ros.health.told_readiness import ToldReadiness, is_guidance
from cable_tracker.sequences import node_topics
from cable_tracker.tracking.status import WARMING_UP


def status(message, name="tracker", **values):
    pairs = [SimpleNamespace(key=key, value=value) for key, value in values.items()]
    return SimpleNamespace(name=name, message=message, values=pairs)


def test_a_tracker_is_warm_when_it_says_so():
    told = ToldReadiness()
    assert not told.is_warm
    told.hear(status(WARMING_UP))
    assert not told.is_warm
    told.hear(status("INITIALISING"))
    assert told.is_warm


def test_readers_are_counted_by_the_last_part_of_a_topic():
    told = ToldReadiness()
    told.hear(status("", **{"subscribers of /x/state": "2", "subscribers of /x/cross_track": "1"}))
    assert told.has_readers(1, node_topics.STATE, node_topics.CROSS_TRACK)
    assert not told.has_readers(2, node_topics.STATE, node_topics.CROSS_TRACK)
    assert not told.has_readers(1, node_topics.CENTRELINE)


@pytest.mark.parametrize(
    ("name", "is_one"), [("/x/controller: guidance", True), ("tracker", False)]
)
def test_guidance_speaks_of_the_controller(name, is_one):
    assert is_guidance(status("", name)) is is_one
