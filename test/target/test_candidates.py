import numpy as np
import pytest

from cable_tracker.target.candidates import DETECTORS
from cable_tracker.target.measure.working_frame import make_working_frame
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker

STEP = 40_000_000


@pytest.mark.parametrize("name", sorted(DETECTORS))
def test_what_stands_out_is_proposed_first(draw, name):
    image, mask = draw(centre=(220, 90))
    candidates = DETECTORS[name](make_working_frame(image, 320))
    found = candidates[0].mask
    assert (found & mask).sum() / (found | mask).sum() > 0.6


@pytest.mark.parametrize("name", sorted(DETECTORS))
def test_in_even_water_nothing_is_proposed(draw, name):
    assert DETECTORS[name](make_working_frame(draw(centre=None)[0], 320)) == []


def test_a_proposed_target_is_claimed_after_it_was_confirmed(draw):
    tracker = TargetTracker(TargetParameters(detector="contours"))
    statuses = [
        tracker.process(draw(centre=(100 + 3 * number, 120), seed=number)[0], number * STEP)
        for number in range(1, 8)
    ]
    assert statuses[0].status.value == "INITIALISING"
    assert statuses[-1].status.value == "TRACKING"


def test_what_was_proposed_and_is_gone_at_once_is_never_claimed(draw):
    tracker = TargetTracker(TargetParameters(detector="contours"))
    tracker.process(draw()[0], STEP)
    for number in range(2, 12):
        estimate = tracker.process(draw(centre=None, seed=number)[0], number * STEP)
        assert estimate.status.value == "INITIALISING"
    np.testing.assert_array_less(estimate.presence, 0.5)
