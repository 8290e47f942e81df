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
