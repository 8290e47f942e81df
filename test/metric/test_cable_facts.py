import numpy as np

from cable_tracker.metric.cable_facts import (
    METRES_KEYS,
    NO_METRES_KEY,
    cable_facts,
    has_metres,
    read_row_metres,
    row_metres,
)
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Reason, Withheld

KNOWN = CrossTrack(0.1, 0.3, -0.7, 0.06, np.diag([0.02, 0.3, 1e-3, 0.1]), 2.0, -1.5)
NOT_KNOWN = Withheld(Reason.NO_ALTITUDE, "none has come on altitude")


def test_what_is_known_is_read_again_to_the_last_bit():
    facts = cable_facts(KNOWN)
    assert has_metres(facts)
    assert list(facts) == list(METRES_KEYS)
    assert read_row_metres(facts) == row_metres(KNOWN)


def test_nothing_known_gives_the_reason_alone():
    facts = cable_facts(NOT_KNOWN)
    assert facts == {NO_METRES_KEY: str(NOT_KNOWN)}
    assert not has_metres(facts)
    assert read_row_metres(facts) is None
