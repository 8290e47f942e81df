import itertools

import numpy as np
import pytest

from cable_tracker.visualisation import palette


def _luminance(colour):
    return float(np.dot(colour, (0.299, 0.587, 0.114)))


def test_every_status_of_the_design_has_a_colour():
    assert palette.status_colour("TRACKING") == palette.GREEN
    assert palette.status_colour("LOST") == palette.RED
    assert palette.status_colour("INITIALISING") == palette.AMBER
    for status in ("REFUSED", "STALE", "DISABLED", "anything"):
        assert palette.status_colour(status) == palette.GREY


def test_channels_are_reversed_for_opencv_and_scaled_for_matplotlib():
    assert palette.to_bgr((1, 2, 3)) == (3, 2, 1)
    assert palette.to_unit((0, 51, 255)) == pytest.approx((0.0, 0.2, 1.0))


def test_lines_differ_to_eyes_without_red_or_green():
    """Red-green blind eyes see the mean of red and green, and blue."""
    for first, second in itertools.combinations(
        (palette.GREEN, palette.RED, palette.AMBER, palette.TRUTH), 2
    ):
        yellow = abs((first[0] + first[1]) - (second[0] + second[1])) / 2
        blue = abs(first[2] - second[2])
        assert max(yellow, blue) > 40


def test_colours_stand_out_from_a_dark_strip():
    for colour in (palette.GREEN, palette.RED, palette.AMBER, palette.GREY, palette.WHITE):
        assert _luminance(colour) > 100
