import cv2
import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.target.model.start import TargetStart


def test_a_box_stands_for_the_ellipse_in_it():
    mask = TargetStart.from_box(100, 50, 180, 90).mask((240, 320), 1.0)
    assert mask.sum() == pytest.approx(np.pi * 40 * 20 * 0.95**2, rel=0.05)
    rows, columns = np.nonzero(mask)
    assert (columns.mean(), rows.mean()) == pytest.approx((139.5, 69.5), abs=0.3)


def test_corners_may_come_in_any_order():
    assert TargetStart.from_box(180, 90, 100, 50).box == (100, 50, 180, 90)


@pytest.mark.parametrize(
    "corners",
    [[[50, 50], [120, 120], [80, 80]], [[0.1, 0.2], [40.1, 60.2], [20.1, 30.2], [9, 13.5]]],
)
def test_corners_on_a_line_are_no_outline(corners):
    with pytest.raises(FrameError, match="line"):
        TargetStart(np.array(corners, dtype=float))


def test_an_outline_that_crosses_itself_has_an_area():
    corners = [[10.0, 10.0], [50.0, 50.0], [50.0, 10.0], [10.0, 50.0]]
    assert TargetStart(np.array(corners)).mask((60, 60), 1.0).sum() > 700


def test_an_outline_is_taken_as_it_is():
    corners = np.array([[20.0, 20.0], [60.0, 20.0], [60.0, 60.0]])
    start = TargetStart(corners)
    assert not start.is_box
    assert start.mask((100, 100), 1.0).sum() == pytest.approx(800, rel=0.08)
    assert start.mask((50, 50), 2.0).sum() == pytest.approx(200, rel=0.2)


@pytest.mark.parametrize("corners", [[[1, 1]], [[1, 1], [np.nan, 9]], [[5, 5], [5, 40]]])
def test_what_is_no_area_is_refused(corners):
    with pytest.raises(FrameError):
        TargetStart(np.array(corners, dtype=float))


@pytest.mark.parametrize(
    ("box", "reason"),
    [
        ((-10, -10, 400, 300), "is as large as the picture of 320x240"),
        ((400, 100, 460, 150), "lies outside the picture of 320x240"),
    ],
)
def test_a_mark_must_be_in_the_picture_and_less_than_all_of_it(box, reason):
    with pytest.raises(FrameError, match=reason):
        TargetStart.from_box(*box).check((320, 240))


@pytest.mark.parametrize("far", [1e7, 1e9, 1e30])
@pytest.mark.filterwarnings("error")
def test_corners_far_outside_mark_what_they_enclose_of_the_picture(far):
    corners = np.array([[100.0, 50.0], [far, 50.0], [far, 90.0], [100.0, 90.0]])
    expected = np.zeros((240, 320), bool)
    expected[50:90, 100:] = True
    mask = TargetStart(corners).mask((240, 320), 1.0)
    assert (mask != expected).sum() <= 220 + 40
    mirrored = TargetStart(320.0 - corners[:, ::-1]).mask((320, 320), 1.0)
    assert mirrored.any()
    assert not mirrored[:, :229].any()


@pytest.mark.filterwarnings("error")
def test_a_box_that_ends_far_outside_is_as_one_that_ends_outside():
    """Of its ellipse nothing need lie in the picture."""
    far, near = (TargetStart.from_box(100, 50, end, 90) for end in (1e30, 1e6))
    np.testing.assert_array_equal(far.mask((240, 320), 1.0), near.mask((240, 320), 1.0))


@pytest.mark.parametrize("zoom", [0.5, 1.0, 3.0])
def test_corners_that_a_marked_target_may_have_are_taken_as_they_are(zoom):
    corners = np.random.default_rng(2).uniform(-9000.0, 9000.0, (5, 2))
    expected = np.zeros((240, 320), np.uint8)
    points = np.round((corners / zoom - 0.5) * 16).astype(np.int32)
    cv2.fillPoly(expected, [points], 1, cv2.LINE_8, 4)
    np.testing.assert_array_equal(TargetStart(corners).mask((240, 320), zoom), expected > 0)
