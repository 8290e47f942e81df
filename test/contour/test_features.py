import numpy as np
import pytest

from cable_tracker.contour.chain_code import outline
from cable_tracker.contour.features import (
    asymmetry,
    feature_points,
    orientation_histogram,
    segment_histograms,
    turns,
    upright_ratio,
)


def test_feature_points_are_those_of_table_3():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    points = feature_points(orientations)
    assert [point.index for point in points] == [0, 8]
    assert points[1].is_convex


def test_turns_go_the_short_way():
    assert turns(np.array([7, 0, 7, 3, 4, 1])).tolist() == [1, -1, 4, 1, -3]


def test_segments_share_the_chain_between_them():
    orientations = np.array([0, 1, 2, 3, 3, 3, 3, 4, 4, 5, 7, 7, 6, 7, 0, 7, 0])
    histograms = segment_histograms(orientations)
    assert histograms[0] == pytest.approx(np.array([1, 1, 1, 4, 1, 0, 0, 0]) / 8)
    assert histograms.sum(axis=1) == pytest.approx([1.0, 1.0])


def test_a_rectangle_stands_or_lies_as_its_sides_say():
    mask = np.zeros((70, 70), bool)
    mask[5:61, 10:32] = True
    upright = orientation_histogram(outline(mask).orientations)
    lying = orientation_histogram(outline(mask.T).orientations)
    assert upright_ratio(upright) == pytest.approx(2.62, abs=0.01)
    assert upright_ratio(lying) == pytest.approx(0.382, abs=0.002)


def test_what_has_no_horizontal_step_stands_infinitely():
    assert upright_ratio(orientation_histogram(np.array([2, 2, 6, 6]))) == float("inf")


def test_shapes_with_a_centre_are_symmetric(draw_disc):
    circle = orientation_histogram(outline(draw_disc(60, 60, (30, 30), 20)).orientations)
    assert asymmetry(circle) == pytest.approx(0.0)
    triangle = np.tri(40, 40, dtype=bool)
    assert asymmetry(orientation_histogram(outline(triangle).orientations)) > 0.5
