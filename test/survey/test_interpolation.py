import numpy as np

from cable_tracker.survey.interpolation import interpolated

KNOWN = np.array([0.0, 2.0, 4.0])
COLUMNS = np.array([[0.0, 10.0], [2.0, 20.0], [2.0, 40.0]])


def test_columns_are_straight_between_what_is_known_and_level_outside():
    found = interpolated(np.array([-1.0, 1.0, 3.0, 9.0]), KNOWN, COLUMNS)
    assert found.tolist() == [[0.0, 10.0], [1.0, 15.0], [2.0, 30.0], [2.0, 40.0]]


def test_one_place_gives_one_row():
    assert interpolated(3.0, KNOWN, COLUMNS).tolist() == [2.0, 30.0]
