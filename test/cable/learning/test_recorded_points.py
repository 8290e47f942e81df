from __future__ import annotations

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.learning.recorded_points import measure_points
from cable_tracker.cable.measure.borders.border_points import (
    BLOCK,
    SMALLEST_RESPONSE,
    weaker_common_contrast,
)
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.state import CableState

SIZE = (210, 170)
WIDTH = 20.0
OUTSIDE, BEHIND, DEEP = 6.0, WIDTH / 4, WIDTH / 2
"""How far from a border the bottom [px at the reference width] and the cable are looked at [px]."""


@pytest.fixture
def image(noise_picture) -> WorkingImage:
    """Texture that is scanned along every line: more lines than are measured together."""
    image = plain_image(noise_picture(3, SIZE, 25.0), sample_spacing=1.0)
    assert len(image.scan.rows.places) > 2 * BLOCK
    return image


def literal_points(state: np.ndarray, side: float, image: WorkingImage) -> np.ndarray:
    """Response, size of the slope and contrast, one point after the other, shape (P, 3)."""
    distance, angle, width, skew = state[:4]
    normal, offset = angle + side * skew, (distance + side * width / 2) * np.cos(skew)
    steep = abs(np.cos(normal)) >= abs(np.sin(normal))
    lines = image.scan.rows if steep else image.scan.columns
    along, across = (np.cos(normal), np.sin(normal))[:: 1 if steep else -1]
    last = lines.smooth.shape[1] - 1
    outward = side / along
    shape, across_it = image.scan.shape, np.array([np.cos(normal), np.sin(normal)])
    covariance = np.array([[shape.xx, shape.xy], [shape.xy, shape.yy]])
    gain = 1.0 / np.sqrt(across_it @ covariance @ across_it)
    points = []
    for place, gradients, levels in zip(lines.places, lines.gradients, lines.smooth, strict=True):
        position = (offset - across * place) / along + last / 2
        if not 0.0 <= position <= last:
            continue
        change_along, change_across, slope = (
            np.interp(position, np.arange(last + 1), channel) for channel in gradients.T
        )
        response = -side * gain * (along * change_along + across * change_across)
        slope *= gain * image.scale / along
        outside, behind, deep = (
            levels[int(np.clip(position + depth * outward + 0.5, 0, last))]
            for depth in (OUTSIDE * image.scale, -BEHIND, -DEEP)
        )
        contrast = weaker_common_contrast(behind - outside, deep - outside)
        points.append((response, abs(slope) / (abs(response) + SMALLEST_RESPONSE), contrast))
    return np.array(points)


@pytest.mark.parametrize(
    "state",
    [
        CableState(0.0, 0.0, WIDTH, 0.0),
        CableState(10.0, 0.6, WIDTH, 0.0),
        CableState(70.0, -0.7, WIDTH, 0.0),
        CableState(-20.0, 1.5, WIDTH, 0.0),
    ],
    ids=["upright", "turned", "leaves at the side", "flat"],
)
def test_points_are_those_that_are_measured_one_by_one(state, image):
    found = measure_points(state.to_array()[None], image)
    measures = np.stack(
        (found.measures.responses, found.measures.slopes, found.measures.contrasts), axis=1
    )
    for border, side in enumerate((-1.0, 1.0)):
        expected = literal_points(state.to_array(), side, image)
        assert len(expected) > BLOCK
        np.testing.assert_allclose(measures[found.borders == border], expected, atol=2e-3)


def test_a_cable_beside_the_picture_has_no_points(image):
    assert len(measure_points(CableState(500.0, 0.3, WIDTH).to_array()[None], image).borders) == 0
