import numpy as np
import pytest

from cable_tracker.contour.features import (
    feature_points,
    segment_histograms,
    turns,
)


def test_feature_points_are_those_of_table_3():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    assert feature_points(orientations) == [0, 8]


def test_turns_go_the_short_way():
    assert turns(np.array([7, 0, 7, 3, 4, 1])).tolist() == [1, -1, 4, 1, -3]


def test_segments_share_the_chain_between_them():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    histograms = segment_histograms(orientations)
    assert histograms[0] == pytest.approx(np.array([1, 1, 1, 4, 1, 0, 0, 0]) / 8)
    assert histograms.sum(axis=1) == pytest.approx([1.0, 1.0])
