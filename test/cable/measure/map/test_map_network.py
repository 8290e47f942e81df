from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.map.map_network import (
    CELL,
    LARGEST,
    LIGHT_CELLS,
    STRIDE,
    TALLEST,
    cells_within,
    make_cable_map,
    normalised,
    padded,
)
from cable_tracker.cable.measure.map.map_strips import strip_shares
from cable_tracker.cable.model.state import CableState

CABLE = CableState(25.0, 0.3, 40.0, 0.03)


@pytest.fixture
def picture(draw_strip, rng):
    drawn = draw_strip(CABLE, (320, 240), strip=140.0, ground=90.0)
    grain = cv2.GaussianBlur(rng.normal(0.0, 60.0, drawn.shape), (0, 0), 2.0)
    return np.clip(drawn + grain * (drawn < 115.0) + rng.normal(0.0, 4.0, drawn.shape), 0, 255)


def shares_of(where):
    scaled = CABLE.to_array()
    scaled[[0, 2]] *= where.cell / CELL
    return strip_shares(scaled, where)


def test_the_map_shows_the_cable(picture):
    where = make_cable_map(picture.astype(np.uint8), 320)
    shares = shares_of(where)
    assert where.probabilities.shape == (60, 80)
    assert where.probabilities[shares == 1.0].mean() > 0.7
    assert where.probabilities[shares == 0.0].mean() < 0.1
    assert where.mass == pytest.approx(where.probabilities.sum(), rel=1e-5)


def test_noise_is_no_cable(rng):
    noise = rng.normal(128.0, 20.0, (240, 320)).astype(np.float32)
    assert make_cable_map(noise, 320).probabilities.mean() < 0.05


@pytest.mark.parametrize("size", [(640, 480), (160, 120), (320, 262), (331, 240)])
def test_the_map_lies_in_the_frame_whatever_its_size(picture, size):
    resized = cv2.resize(picture.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    where = make_cable_map(resized, size[0])
    assert where.cell == pytest.approx(CELL * size[0] / 320)
    rows, columns = where.probabilities.shape
    right, bottom = where.left + (columns - 1) * where.cell, where.top - (rows - 1) * where.cell
    half_width, half_height = 0.5 * size[0], 0.5 * size[1]
    assert -half_width < where.left < -half_width + where.cell
    assert half_width - where.cell < right < half_width
    assert half_height - where.cell < where.top < half_height + 0.01 * size[1]
    assert -half_height - 0.01 * size[1] < bottom <= -half_height + where.cell
    if size[0] * 3 == size[1] * 4:
        shares = shares_of(where)
        assert where.probabilities[shares == 1.0].mean() > 0.6


def test_a_picture_twice_as_large_in_the_frame_has_cells_twice_as_large(picture):
    small, large = (make_cable_map(picture.astype(np.uint8), width) for width in (320, 640))
    assert large.cell == 2.0 * small.cell
    assert large.left == 2.0 * small.left
    assert np.array_equal(large.probabilities, small.probabilities)


def test_threads_do_not_disturb_one_another(picture):
    pictures = [np.roll(picture, 8 * shift, axis=1).astype(np.uint8) for shift in range(8)]
    alone = [make_cable_map(each, 320).probabilities for each in pictures]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda each: make_cable_map(each, 320).probabilities, pictures))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one, other)


def test_levels_lose_the_light_and_their_scale(picture):
    levels = picture.astype(np.float32)
    bright = normalised(3.0 * levels + 200.0)
    assert bright.shape == (len(LIGHT_CELLS), 240, 320)
    assert np.abs(bright).max() <= LARGEST
    assert np.quantile(np.abs(bright - normalised(levels)), 0.99) < 0.05 * LARGEST


def test_a_few_glaring_stones_do_not_change_the_scale(picture):
    levels = picture.astype(np.float32)
    glaring = levels.copy()
    glaring[100:106, 40:46] = 255.0
    far = np.s_[:, :, 160:]
    np.testing.assert_allclose(normalised(glaring)[far], normalised(levels)[far], atol=0.3)


def test_the_inside_of_a_wide_cable_stays_with_the_larger_cells():
    levels = np.full((240, 320), 90.0, np.float32)
    levels[:, 130:190] = 140.0
    narrow, wide, whole = normalised(levels)[:, 120, 160]
    assert abs(narrow) < 0.5
    assert min(wide, whole) > 1.0


@pytest.mark.parametrize("level", [0.0, 255.0, 1e12])
def test_a_picture_of_one_level_shows_nothing(level):
    where = make_cable_map(np.full((240, 320), level, np.float32), 320)
    assert where.probabilities.max() < 0.05


def test_a_tall_picture_is_reduced_further(picture):
    tall = cv2.resize(picture.astype(np.float32), (16, 240), interpolation=cv2.INTER_AREA)
    where = make_cable_map(tall, 16)
    assert where.probabilities.shape == (TALLEST // CELL, 11)
    assert where.cell == pytest.approx(CELL * 240 / TALLEST, rel=0.02)


@pytest.mark.parametrize("size", [(2400, 16), (16, 8000)])
def test_a_picture_too_narrow_for_a_cell_has_no_map(size):
    assert make_cable_map(np.zeros(size[::-1], np.uint8), size[0]).probabilities.shape == (0, 0)


@given(st.integers(16, 400), st.integers(16, 400))
def test_padding_repeats_margins_of_whole_cells_up_to_the_stride(width, height):
    levels = np.arange(2 * width * height, dtype=np.float32).reshape(2, height, width)
    whole, (left, above) = padded(levels)
    assert all(side % STRIDE == 0 for side in whole.shape[1:])
    assert left % CELL == above % CELL == 0
    assert np.array_equal(whole[:, above : above + height, left : left + width], levels)
    assert np.array_equal(whole[:, 0, 0], levels[:, 0, 0])
    assert np.array_equal(whole[:, -1, -1], levels[:, -1, -1])


@given(st.integers(0, 31), st.integers(4, 400))
def test_cells_within_are_those_whose_centres_are(margin, length):
    cells = [cell for cell in range(120) if margin <= CELL * (cell + 0.5) < margin + length]
    assert list(cells_within(margin, length)) == cells
