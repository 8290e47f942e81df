import numpy as np
import pytest

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE
from cable_tracker.errors import ParameterError
from cable_tracker.ros.rigs.soak.actions import ACTIONS, random_value
from cable_tracker.ros.rigs.soak.faults import CHANGES, COMPRESSED_CHANGES, Fault


def test_every_fault_is_a_spoilt_frame_or_something_done():
    assert set(Fault) == ACTIONS.keys() | CHANGES.keys() | COMPRESSED_CHANGES.keys()
    assert not ACTIONS.keys() & (CHANGES.keys() | COMPRESSED_CHANGES.keys())


@pytest.mark.parametrize("spec", PARAMETER_TABLE, ids=lambda spec: spec.name)
def test_a_storm_has_good_values_and_bad_ones(spec):
    rng = np.random.default_rng(4)
    good = 0
    for _ in range(60):
        try:
            spec.coerce(random_value(spec, rng))
            good += 1
        except ParameterError:
            pass
    assert 0 < good < 60
