import numpy as np

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE
from cable_tracker.errors import ParameterError
from cable_tracker.ros.rigs.soak.actions import ACTIONS, random_value
from cable_tracker.ros.rigs.soak.faults import CHANGES, COMPRESSED_CHANGES, Fault


def test_every_fault_is_a_spoilt_frame_or_something_done():
    assert set(Fault) == ACTIONS.keys() | CHANGES.keys() | COMPRESSED_CHANGES.keys()
    assert not ACTIONS.keys() & (CHANGES.keys() | COMPRESSED_CHANGES.keys())


def is_good(spec, value) -> bool:
    try:
        spec.coerce(value)
    except ParameterError:
        return False
    return True


def test_a_storm_has_good_values_and_bad_ones():
    for spec in PARAMETER_TABLE:
        rng = np.random.default_rng(4)
        good = sum(is_good(spec, random_value(spec, rng)) for _ in range(60))
        assert 0 < good < 60, spec.name
