import math

import pytest

from cable_tracker.survey.routes.crossings import LocatedObservation, merge_observations


def test_a_line_straight_across_is_so_on_whichever_side_of_a_right_angle_it_is_seen():
    observations = [
        LocatedObservation(10.0, 1.5, math.radians(angle), row)
        for row, angle in enumerate((89, -89, 88, -88))
    ]
    ((_, across, count),) = merge_observations(observations)
    assert math.degrees(across) == pytest.approx(88.5)
    assert count == 4
