import numpy as np
import pytest

from cable_tracker.survey.recording import middle_fix

NEAR = np.array([[54.0 + 1e-5 * k, 8.0 - 2e-5 * k] for k in range(9)])


@pytest.mark.parametrize("old", [[10.0, 8.0], [54.0, -172.0], [-90.0, 0.0]])
def test_an_old_place_that_a_receiver_begins_with_is_not_the_datum(old):
    fixes = np.vstack(([old] * 4, NEAR))
    assert middle_fix(fixes) in list(map(tuple, NEAR.tolist()))


def test_the_only_fix_is_the_datum():
    assert middle_fix(np.array([[54.0, 8.0]])) == (54.0, 8.0)


def test_on_both_sides_of_180_degrees_fixes_are_near():
    fixes = np.array([[0.0, 20.0], [0.0, 179.9999], [0.0, -179.9999], [0.0, 179.9998]])
    assert middle_fix(fixes)[1] != 20.0
