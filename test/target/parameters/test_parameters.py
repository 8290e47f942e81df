import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.target.parameters.parameters import TargetParameters


def test_shares_must_leave_particles_to_follow():
    with pytest.raises(ParameterError, match="refinement_share"):
        TargetParameters(place_share=0.6, refinement_share=0.4)


def test_limits_of_presence_are_in_order():
    with pytest.raises(ParameterError, match="presence_to_lose"):
        TargetParameters(presence_to_track=0.3)


@pytest.mark.parametrize("name", ["presence_to_track", "presence_to_lose"])
def test_limits_that_presence_never_reaches_are_out_of_range(name):
    with pytest.raises(ParameterError, match=rf"{name}: 1.0 is outside 0 .. 0.998"):
        TargetParameters(**{name: 1.0})
