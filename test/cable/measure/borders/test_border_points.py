from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.learning.recorded_points import measure_points
from cable_tracker.cable.measure.borders.border_points import weaker_common_contrast
from cable_tracker.cable.model.state import CableState

SIZE = (160, 120)
STRIP = CableState(12.0, 0.2, 24.0, 0.03)


@pytest.mark.parametrize("angle", [0.0, 0.6, -0.7, np.pi / 2, 1.0, -1.2])
def test_a_border_is_measured_once_on_every_line_that_it_crosses_steeply(angle):
    image = plain_image(np.zeros(SIZE[::-1], np.uint8))
    points = measure_points(np.array([[0.0, angle, 8.0, *[0.0] * 5]]), image)
    steep = abs(np.cos(angle)) >= abs(np.sin(angle))
    lines = image.scan.rows if steep else image.scan.columns
    for border, offset in enumerate((-4.0, 4.0)):
        along, across = (np.cos(angle), np.sin(angle))[:: 1 if steep else -1]
        crossings = (offset - across * lines.places) / along
        inside = np.abs(crossings) <= (lines.smooth.shape[1] - 1) / 2
        assert (points.borders == border).sum() == inside.sum() > 0


def test_on_the_border_of_a_strip_the_response_is_high_the_slope_low_and_the_inside_brighter(
    draw_strip, noise_picture
):
    picture = draw_strip(STRIP, SIZE, strip=180.0, ground=80.0).astype(np.float32)
    picture += noise_picture(1, SIZE, 6.0).astype(np.float32) - 110.0
    image = plain_image(picture)
    here, beside = (
        measure_points(state.to_array()[None], image).measures
        for state in (STRIP, replace(STRIP, width=STRIP.width + 6.0))
    )
    assert np.median(here.responses) > 5.0
    assert np.median(here.contrasts) > 2.0
    assert np.median(np.abs(here.slopes)) < 0.15 < np.median(np.abs(beside.slopes))


def test_the_contrast_is_the_weaker_of_both_parts_and_zero_where_their_signs_differ():
    behind = np.array([3.0, 3.0, -3.0, -3.0, 0.0], np.float32)
    middle = np.array([2.0, -2.0, -5.0, 5.0, 1.0], np.float32)
    assert list(map(weaker_common_contrast, behind, middle)) == [2.0, 0.0, -3.0, 0.0, 0.0]
