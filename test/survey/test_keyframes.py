import numpy as np
from survey_dives import DISK, Plan, make_dive

from cable_tracker.survey.keyframes import make_keyframes
from cable_tracker.survey.memory_mapped import Disk


def test_a_vehicle_that_stands_still_is_one_look():
    dive = make_dive(Plan(length=5.0))
    rows = dive.table.rows
    poses = np.tile([1.0, 2.0, 0.1], (len(rows), 1))
    assert len(make_keyframes(rows, poses, DISK).look_lines) == 1


def test_rows_after_the_last_one_with_a_place_are_of_no_keyframe():
    rows = make_dive(Plan(length=5.0)).table.rows
    poses = np.zeros((len(rows), 3))
    poses[:, 0] = 0.1 * np.arange(len(rows))
    poses[40:60] = np.nan
    poses[80:] = np.nan
    for block in (4096, 16):
        keyframes = make_keyframes(rows, poses, Disk(block=block))
        owners = keyframes.of(np.arange(len(rows)))
        assert owners.tolist() == [*range(40), *[-1] * 20, *range(40, 60), *[-1] * 20]
