import numpy as np
from survey_dives import Plan, make_dive

from cable_tracker.survey.smoothing.keyframes import make_keyframes


def test_a_vehicle_that_stands_still_is_one_look():
    dive = make_dive(Plan(length=5.0))
    rows = dive.table.rows
    poses = np.tile([1.0, 2.0, 0.1], (len(rows), 1))
    assert len(make_keyframes(rows, poses).places) == 1
