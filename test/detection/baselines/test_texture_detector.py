from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.texture_detector import Cells, cable_cells, describe_cells

STRAIGHTNESS, ABRUPTNESS, DISCONTINUITY, GRANULARITY, BLURRINESS = range(5)


@pytest.fixture
def strip(draw_strip) -> Cells:
    return describe_cells(draw_strip(CableState(0.0, 0.4, 60.0)).astype(np.float32))


@pytest.fixture
def grit(rng) -> Cells:
    return describe_cells(rng.normal(110.0, 25.0, (240, 320)).astype(np.float32))


def medians(cells: Cells) -> np.ndarray:
    return np.median(cells.descriptors, axis=0)


def test_a_flat_picture_has_no_cells_with_contours():
    assert len(describe_cells(np.full((120, 160), 90.0, np.float32)).positions) == 0


def test_borders_are_straighter_than_grit(strip, grit):
    assert medians(strip)[STRAIGHTNESS] > 0.85
    assert medians(grit)[STRAIGHTNESS] < 0.6


@pytest.mark.parametrize("descriptor", [ABRUPTNESS, DISCONTINUITY, GRANULARITY])
def test_borders_are_less_abrupt_broken_and_grainy_than_grit(strip, grit, descriptor):
    assert medians(strip)[descriptor] < medians(grit)[descriptor]


def test_faint_borders_are_blurrier(draw_strip, strip):
    faint = draw_strip(CableState(0.0, 0.4, 60.0), strip=76.0, ground=70.0).astype(np.float32)
    assert medians(describe_cells(faint))[BLURRINESS] > medians(strip)[BLURRINESS]


def test_the_point_of_a_cell_lies_on_the_border(strip):
    across = strip.positions @ [np.cos(0.4), np.sin(0.4)]
    np.testing.assert_allclose(np.abs(across), 30.0, atol=0.7)


def test_cells_on_a_border_are_cable_and_grit_is_not(strip, grit):
    # Cells that the border only grazes hold too little of it.
    assert len(cable_cells(strip)) > 0.7 * len(strip.positions)
    assert len(cable_cells(grit)) < 0.05 * len(grit.positions)
