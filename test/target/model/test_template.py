import math

import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.template import (
    MOST_SIDE,
    RING,
    SIDE,
    UNIT,
    centroid,
    check_area,
    distances_about,
    template_of_mask,
)


def distance_at(template, points):
    columns = np.round((SIDE - 1) / 2 + points[:, 0] * UNIT).astype(int)
    rows = np.round((SIDE - 1) / 2 - points[:, 1] * UNIT).astype(int)
    return template.distances[rows, columns]


def test_a_template_has_area_one_about_its_centroid(draw):
    template = template_of_mask(draw(centre=(90, 70))[1], 60, 1.0)
    inside = template.distances < 0.0
    assert inside.sum() / UNIT**2 == pytest.approx(1.0, rel=0.06)
    assert centroid(inside) == pytest.approx((0.0, 0.0), abs=0.6)


def test_its_points_lie_inside_and_in_the_ring(draw):
    template = template_of_mask(draw()[1], 60, 1.0)
    assert template.inside.shape == template.around.shape == (60, 2)
    assert (distance_at(template, template.inside) < 0.05).all()
    around = distance_at(template, template.around)
    assert ((around > RING[0] - 0.06) & (around < RING[1] + 0.06)).all()


def test_a_turned_shape_is_turned_back(draw):
    flat, turned = draw(tilt=0)[1], draw(tilt=30)[1]
    size = math.sqrt(flat.sum())
    straight = distances_about(flat, centroid(flat), size, 0.0, SIDE) < 0
    back = distances_about(turned, centroid(turned), size, math.radians(30), SIDE) < 0
    assert (straight ^ back).sum() < 0.08 * straight.sum()


def test_extent_is_that_of_the_shape(draw):
    template = template_of_mask(draw(axes=(30, 10))[1], 60, 1.0)
    assert template.extent(0.0) == pytest.approx((30 / template.size, 10 / template.size), abs=0.06)
    assert template.extent(math.pi / 2) == pytest.approx(template.extent(0.0)[::-1], abs=0.03)


@pytest.mark.parametrize("axes", [(22, 14), (40, 40), (60, 9)])
def test_the_map_of_a_compact_shape_has_the_usual_size(draw, axes):
    assert template_of_mask(draw(axes=axes)[1], 60, 1.0).distances.shape == (SIDE, SIDE)


def bar(length, width):
    """A mask of a bar across a picture of 320 by 240 px."""
    mask = np.zeros((240, 320), bool)
    mask[120 : 120 + width, 160 - length // 2 : 160 + length // 2] = True
    return mask


@pytest.mark.parametrize(("length", "width"), [(160, 14), (200, 10), (300, 4)])
def test_the_map_holds_all_of_a_long_shape_and_its_ring(length, width):
    template = template_of_mask(bar(length, width), 60, 1.0)
    half_length = length / 2 / template.size
    assert template.extent(0.0)[0] == pytest.approx(half_length, abs=0.1)
    assert template.reach == pytest.approx(half_length, abs=0.1)
    assert template.inside.shape == template.around.shape == (60, 2)
    assert np.abs(template.inside[:, 0]).max() > 0.8 * half_length
    assert len(template.distances) / UNIT / 2 >= half_length + RING[1]


def test_the_map_does_not_grow_without_bounds():
    assert len(template_of_mask(np.ones((1, 4000), bool), 60, 1.0).distances) == MOST_SIDE


@pytest.mark.parametrize(("width", "is_bar"), [(10, True), (14, False), (40, False)])
def test_what_is_fourteen_times_as_long_as_wide_is_a_bar(width, is_bar):
    assert template_of_mask(bar(160, width), 60, 1.0).is_bar is is_bar


def test_a_thin_ring_is_no_bar(draw):
    ring = draw(axes=(60, 60))[1] & ~draw(axes=(57, 57))[1]
    assert not template_of_mask(ring, 60, 1.0).is_bar


def marks(side, zoom):
    """Masks of boxes of a side [px of the frame] that lie differently between the pixels."""
    for offset in np.ndindex(5, 5):
        left, top = zoom * (8.0 + np.array(offset) / 5.0)
        start = TargetStart.from_box(left, top, left + side, top + side)
        yield start.mask((20, 20), zoom)


def test_specks_are_refused():
    mask = np.zeros((20, 20), bool)
    mask[3:6, 3:6] = True
    with pytest.raises(FrameError, match="too small to have a shape; mark a box of 4x4 px"):
        template_of_mask(mask, 60, 1.0)


@pytest.mark.parametrize(("zoom", "side"), [(1.0, 4), (2.0, 7), (6.0, 20), (12.0, 40)])
def test_the_box_that_is_asked_for_instead_of_a_speck_is_taken_wherever_it_lies(zoom, side):
    with pytest.raises(FrameError, match=f"mark a box of {side}x{side} px at least"):
        for mask in marks(max(2.9 * zoom, 3.0), zoom):
            check_area(mask, zoom)
    for mask in marks(side, zoom):
        check_area(mask, zoom)
