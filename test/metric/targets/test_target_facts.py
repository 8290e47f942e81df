import numpy as np

from cable_tracker.metric.targets.relative_state import TargetSighting, begin_relative_state
from cable_tracker.metric.targets.target_facts import (
    TARGET_METRES_KEYS,
    WHY_NOT_KEY,
    has_bearing,
    has_position,
    target_facts,
)
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Reason, Withheld

NOT_KNOWN = Withheld(Reason.RANGE_UNKNOWN, "the target has not been seen as a whole yet")
RAY = np.array([0.0, 0.6, 0.8])
CAMERA_POSITION = np.array([0.5, 0.0, -0.1])


def test_what_is_known_is_told_to_the_last_bit():
    state = begin_relative_state(TargetSighting(0.1, -0.2, 0.05, True), 0.4)
    facts = target_facts(TargetMetres(RAY, state), CAMERA_POSITION)
    assert has_bearing(facts)
    assert has_position(facts)
    assert list(facts) == [key for key in TARGET_METRES_KEYS if key != WHY_NOT_KEY]
    assert [float(facts[key]) for key in ("bearing_x", "bearing_y", "bearing_z")] == list(RAY)
    position = [float(facts[key]) for key in ("x", "y", "z")]
    assert position == list(state.position() + CAMERA_POSITION)
    assert float(facts["range"]) == state.range


def test_a_bearing_without_a_range_says_why_there_is_no_position():
    facts = target_facts(TargetMetres(RAY, NOT_KNOWN), CAMERA_POSITION)
    assert has_bearing(facts)
    assert not has_position(facts)
    assert facts[WHY_NOT_KEY] == str(NOT_KNOWN)


def test_nothing_known_gives_the_reason_alone():
    facts = target_facts(TargetMetres(NOT_KNOWN, NOT_KNOWN), CAMERA_POSITION)
    assert list(facts) == [WHY_NOT_KEY]
