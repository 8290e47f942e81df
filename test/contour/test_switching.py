import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.contour.switching import EXTERIOR, INNER, INTERIOR, OUTER, levels_of_mask


def reference(mask):
    levels = np.where(mask, INTERIOR, EXTERIOR)
    for row, column in np.ndindex(mask.shape):
        for i, j in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
            inside_picture = 0 <= i < mask.shape[0] and 0 <= j < mask.shape[1]
            if inside_picture and mask[i, j] != mask[row, column]:
                levels[row, column] = INNER if mask[row, column] else OUTER
    return levels


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_levels_are_those_of_the_definition(height, width, seed):
    mask = np.random.default_rng(seed).random((height, width)) < 0.5
    np.testing.assert_array_equal(levels_of_mask(mask), reference(mask))
