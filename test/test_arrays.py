import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.arrays import eight_bits, interpolated, shares_of, true_runs

KNOWN = np.array([0.0, 2.0, 4.0])
COLUMNS = np.array([[0.0, 10.0], [2.0, 20.0], [2.0, 40.0]])


def test_grey_levels_are_rounded_and_clipped():
    levels = eight_bits(np.array([[-3.0, 0.4, 0.6], [254.6, 255.4, 300.0]], np.float32))
    assert levels.dtype == np.uint8
    assert levels.tolist() == [[0, 0, 1], [255, 255, 255]]


def test_eight_bits_stay_as_they_are():
    image = np.arange(6, dtype=np.uint8).reshape(2, 3)
    assert eight_bits(image) is image


@given(st.lists(st.booleans(), max_size=30))
def test_runs_cover_the_mask_and_nothing_else(flags):
    mask = np.array(flags, bool)
    covered = np.zeros(len(flags), bool)
    last_end = -1
    for start, end in true_runs(mask):
        assert last_end < start < end
        covered[start:end] = True
        last_end = end
    assert (covered == mask).all()


def test_columns_are_straight_between_what_is_known_and_level_outside():
    found = interpolated(np.array([-1.0, 1.0, 3.0, 9.0]), KNOWN, COLUMNS)
    assert found.tolist() == [[0.0, 10.0], [1.0, 15.0], [2.0, 30.0], [2.0, 40.0]]


def test_one_place_gives_one_row():
    assert interpolated(3.0, KNOWN, COLUMNS).tolist() == [2.0, 30.0]


def test_shares_sum_to_one_and_are_even_where_there_is_nothing():
    assert shares_of(np.array([1.0, 0.0, 3.0])).tolist() == [0.25, 0.0, 0.75]
    assert shares_of(np.zeros(4)).tolist() == [0.25] * 4
