from __future__ import annotations

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.detection.coherent_lines import (
    CELL,
    LEAST_CELLS,
    ORDINARY_SQUARE,
    WHOLE_LENGTH,
    coarse_brightness,
    coarse_texture,
    coherent_votes,
    middle_offset,
)
from cable_tracker.detection.vote_peaks import ANGLE_BINS

BIN = 2.0 * np.pi / ANGLE_BINS


def step_picture(angle, offset, size=(80, 60), height=1.0):
    """A picture that gets brighter across one line, in the direction of an angle."""
    columns, rows = size
    x = np.arange(columns) - 0.5 * (columns - 1)
    y = 0.5 * (rows - 1) - np.arange(rows)
    across = x * np.cos(angle) + y[:, None] * np.sin(angle) - offset
    return (height * (across > 0.0)).astype(np.float32)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.6, np.pi, -1.2])
@pytest.mark.parametrize("offset", [-9.0, 0.0, 14.0])
def test_the_highest_vote_is_for_the_line_and_the_side_that_is_brighter(rng, angle, offset):
    picture = step_picture(angle, offset) + rng.normal(0.0, 0.5, (60, 80)).astype(np.float32)
    votes = coherent_votes(picture)
    row, column = np.unravel_index(votes.argmax(), votes.shape)
    turned = (row * BIN - angle + np.pi) % (2.0 * np.pi) - np.pi
    assert abs(turned) <= 2.0 * BIN
    assert abs(column - middle_offset(picture) - offset) <= 2.0


def test_many_weak_steps_that_agree_outweigh_a_strong_one(rng):
    picture = 0.3 * step_picture(0.0, -15.0) + rng.normal(0.0, 0.3, (60, 80)).astype(np.float32)
    picture[26:34, 50:] += 5.0
    votes = coherent_votes(picture)
    middle = middle_offset(picture)
    weak = votes[0, middle - 17 : middle - 12].max()
    strong = votes[0, middle + 8 : middle + 13].max()
    assert weak > strong > 0.0


def reference_votes(right, up, angle, whole):
    """Agreement along the lines of one direction, cell by cell."""
    rows, columns = right.shape
    middle = middle_offset(right)
    cells = [[] for _ in range(2 * middle + 1)]
    for row in range(rows):
        for column in range(columns):
            x, y = column - 0.5 * (columns - 1), 0.5 * (rows - 1) - row
            offset = int(np.floor(x * np.cos(angle) + y * np.sin(angle) + 0.5)) + middle
            across = right[row, column] * np.cos(angle) + up[row, column] * np.sin(angle)
            cells[offset].append(across)
    votes = np.zeros(2 * middle + 1)
    for offset, values in enumerate(cells):
        squares = np.square(values).sum() + ORDINARY_SQUARE * max(len(values), LEAST_CELLS)
        votes[offset] = np.sum(values) / np.sqrt(squares) * np.sqrt(min(len(values) / whole, 1.0))
    return votes


@pytest.mark.parametrize("number", [1, 17, 44])
def test_votes_are_sums_over_roots_of_sums_of_squares(number):
    # Gradients of one length: none is cut, and their median is that length.
    picture = np.add.outer(np.arange(12.0), 2.0 * np.arange(17.0)).astype(np.float32)
    picture = picture[:, ::-1].copy()
    inner = slice(1, -1)
    votes = coherent_votes(picture)
    right, up = np.gradient(picture)[1], -np.gradient(picture)[0]
    length = np.hypot(right[inner, inner], up[inner, inner])[0, 0]
    # At its edge a picture is mirrored: no gradient across.
    right[:, [0, -1]] = 0.0
    up[[0, -1]] = 0.0
    expected = reference_votes(right / length, up / length, number * BIN, WHOLE_LENGTH * 12)
    np.testing.assert_allclose(votes[number], np.maximum(expected, 0.0), rtol=1e-4, atol=1e-4)
    opposite = votes[number + ANGLE_BINS // 2]
    np.testing.assert_allclose(opposite, np.maximum(-expected, 0.0)[::-1], rtol=1e-4, atol=1e-4)


def test_an_even_picture_has_no_votes():
    assert not coherent_votes(np.full((20, 30), 7.0, np.float32)).any()


def test_a_smooth_strip_is_dark_in_the_texture_whatever_its_grey_level(rng):
    picture = 100.0 + 20.0 * rng.normal(0.0, 1.0, (240, 320))
    picture[:, 140:200] = 100.0 + 2.0 * rng.normal(0.0, 1.0, (240, 60))
    image = plain_image(np.clip(picture, 0.0, 255.0).astype(np.uint8))
    texture = coarse_texture(image)
    assert texture.shape == coarse_brightness(image).shape == (240 / CELL, 320 / CELL)
    assert texture[:, 38:47].max() < texture[:, :30].min() - 1.0


def test_light_and_shade_leave_the_texture_as_it_is(rng):
    picture = 100.0 * (1.0 + 0.2 * rng.normal(0.0, 1.0, (240, 320)).clip(-3.0, 3.0))
    shaded = picture * np.where(np.arange(320) < 160, 0.5, 1.0)
    bright, half = (
        coarse_texture(plain_image(each.astype(np.float32))) for each in (picture, shaded)
    )
    assert np.abs(half - bright)[:, 4:34].mean() < 0.15


@pytest.mark.parametrize("level", [0.0, 255.0])
def test_a_picture_of_one_level_has_an_even_texture(level):
    texture = coarse_texture(plain_image(np.full((240, 320), level, np.float32)))
    # What is left is rounding, which depends on the processor; textures that tell differ by more.
    assert np.ptp(texture) < 0.1
