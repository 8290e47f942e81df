from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus
from cable_tracker.visualisation.target_overlay import draw_target


def estimate(status):
    return TargetEstimate(
        stamp=0,
        status=status,
        image_size=(320, 240),
        state=np.zeros(6),
        covariance=np.eye(6),
        box=(100.0, 80.0, 150.0, 120.0),
        outline=np.array([[105.0, 85.0], [145.0, 85.0], [125.0, 118.0]]),
        presence=0.9,
    )


def test_a_claimed_target_has_box_and_contour():
    picture = draw_target(np.zeros((240, 320), np.uint8), estimate(TrackingStatus.TRACKING), None)
    assert picture.shape == (240, 320, 3)
    assert picture[80, 120].any()
    assert picture[85, 120].any()


def test_a_lost_target_has_neither_box_nor_contour():
    picture = draw_target(np.zeros((240, 320), np.uint8), estimate(TrackingStatus.LOST), None)
    assert not picture[60:130].any()


def test_particles_are_drawn_where_they_are_and_the_frame_is_left_alone():
    frame = np.zeros((240, 320, 3), np.uint8)
    picture = draw_target(
        frame, estimate(TrackingStatus.LOST), np.array([[60.5, -40.5, 0, 0, 0, 0]])
    )
    assert picture[160, 220].any()
    assert not frame.any()


@pytest.mark.parametrize("first", [100, 101])
def test_a_contour_is_drawn_on_the_pixels_whose_centres_it_goes_through(first):
    last = first + 20
    square = np.array([[first, first], [last, first], [last, last], [first, last]]) + 0.5
    claimed = replace(estimate(TrackingStatus.TRACKING), box=None, outline=square)
    picture = draw_target(np.zeros((240, 320), np.uint8), claimed, None)
    rows, columns = np.nonzero(picture[60:].any(axis=2))
    # Lines are smoothed at their edges.
    assert abs(columns.min() - first) <= 1
    assert picture[first + 10, first].sum() > 2 * picture[first + 10, first - 1].sum()
    assert picture[first + 10, last].sum() > 2 * picture[first + 10, last + 1].sum()
    assert rows.max() + 60 - last <= 1
