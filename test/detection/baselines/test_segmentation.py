from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.segmentation import (
    make_grid,
    region_contours,
    straight_segments,
)
from cable_tracker.detection.border_lines import gradient_of


def smooth(image):
    return cv2.GaussianBlur(image.astype(np.float32), (0, 0), 1.5)


def test_the_grid_covers_the_picture_with_nearly_square_cells():
    grid = make_grid((240, 320))
    assert grid.count == 48
    assert grid.cells[0, 0] == 0
    assert grid.cells[-1, -1] == 47
    np.testing.assert_array_equal(np.bincount(grid.cells.ravel()), np.full(48, 1600))


def test_a_grid_that_does_not_divide_evenly_starts_where_it_says():
    grid = make_grid((37, 53))
    firsts = grid.cells[np.ix_(grid.rows, grid.columns)]
    np.testing.assert_array_equal(firsts.ravel(), np.arange(grid.count))
    values = np.arange(grid.count, dtype=float).reshape(firsts.shape)
    np.testing.assert_array_equal(grid.spread(values), grid.cells)


def test_contours_run_along_the_borders_and_not_along_the_cells(draw_strip):
    pixels = smooth(draw_strip(CableState(0.0, 0.0, 41.0)))
    rows, columns = np.nonzero(region_contours(pixels, gradient_of(pixels)))
    assert set(columns) <= {138, 139, 140, 179, 180, 181}
    assert len(set(rows)) > 200


def test_a_flat_picture_has_no_contours():
    pixels = np.full((120, 160), 80.0, np.float32)
    assert not region_contours(pixels, gradient_of(pixels)).any()


def test_the_segments_of_a_border_lie_on_it(draw_strip):
    pixels = smooth(draw_strip(CableState(0.0, 0.35, 60.0)))
    gradient = gradient_of(pixels)
    segments = straight_segments(region_contours(pixels, gradient), gradient)
    segments = segments.selected(segments.lengths > 30)
    assert segments.lengths.max() > 60
    normal = np.array([np.cos(0.35), np.sin(0.35)])
    for ends in (segments.starts, segments.ends):
        np.testing.assert_allclose(np.abs(ends @ normal), 30.0, atol=1.0)
