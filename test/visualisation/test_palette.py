import itertools

import numpy as np
import pytest

from cable_tracker.visualisation import palette


def _luminance(colour):
    return float(np.dot(colour, (0.299, 0.587, 0.114)))


@pytest.mark.parametrize(
    ("status", "colour"),
    [
        ("TRACKING", palette.GREEN),
        ("LOST", palette.RED),
        ("INITIALISING", palette.AMBER),
        *((other, palette.GREY) for other in ("REFUSED", "STALE", "DISABLED", "anything")),
    ],
)
def test_every_status_has_a_colour(status, colour):
    assert palette.status_colour(status) == colour


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


@pytest.mark.parametrize("name", ["GREEN", "RED", "AMBER", "GREY", "WHITE"])
def test_colours_stand_out_from_a_dark_strip(name):
    assert _luminance(getattr(palette, name)) > 100
