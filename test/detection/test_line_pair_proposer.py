from __future__ import annotations

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pair_proposer import (
    CELL,
    LEAST_CELLS,
    MOST_CABLES,
    MOST_FAINT,
    ORDINARY_SQUARE,
    STRONG,
    VOTE_CAP,
    VOTE_SPREAD,
    WHOLE_LENGTH,
    LinePairProposer,
    accumulated_votes,
    coarse_brightness,
    coarse_texture,
    coherent_votes,
    middle_offset,
)
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, PairLimits
from cable_tracker.detection.vote_peaks import ANGLE_BINS

BIN = 2.0 * np.pi / ANGLE_BINS

CABLES = [
    CableState(12.0, 0.2, 24.0, 0.03),
    CableState(-30.0, -0.6, 16.0),
    CableState(10.0, np.pi / 2, 30.0),
    CableState(-10.0, -np.pi / 2 + 0.03, 30.0),
    CableState(0.0, 0.8, 40.0, -0.06),
]


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


def reference_coherent_votes(right, up, angle, whole):
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
    expected = reference_coherent_votes(
        right / length, up / length, number * BIN, WHOLE_LENGTH * 12
    )
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


def propose(image, working_width=320, is_searching=False) -> np.ndarray:
    picture = plain_image(image, working_width)
    proposer = LinePairProposer(DEFAULT_LIMITS, uses_map=True)
    return proposer.propose(picture, is_searching=is_searching)


def nearest(proposals, truth) -> np.ndarray:
    """The proposal with the nearest d, in the chart of the truth, shape (4,)."""
    states = np.zeros((len(proposals), 8))
    states[:, :4] = proposals
    chart = states_in_chart(states, truth.angle)[:, :4]
    return chart[np.argmin(np.abs(chart - truth.to_array()[:4]) @ [1.0, 60.0, 1.0, 60.0])]


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("cable", CABLES, ids=str)
def test_a_cable_in_the_picture_is_proposed(draw_strip, rng, cable, dark):
    strip, ground = (80.0, 160.0) if dark else (160.0, 80.0)
    picture = draw_strip(cable, (160, 120), strip=strip, ground=ground).astype(np.float32)
    picture += rng.normal(0.0, 5.0, picture.shape).astype(np.float32)
    found = nearest(propose(picture), cable)
    assert found[0] == pytest.approx(cable.distance, abs=4.0)
    assert found[1] == pytest.approx(cable.angle, abs=0.07)
    assert found[2] == pytest.approx(cable.width, abs=5.0)
    assert found[3] == pytest.approx(cable.skew, abs=0.07)


@pytest.fixture
def ripples():
    """A sandy bottom whose ripples are far clearer than what lies on it."""
    y, x = np.mgrid[:240, :320]
    grain = np.random.default_rng(5).normal(0.0, 6.0, (240, 320))
    return 100.0 + 18.0 * np.sin(0.35 * x + 0.5 * y + 0.8 * np.sin(0.05 * x)) + grain


FAINT = CableState(25.0, -0.15, 56.0, 0.02)


def is_near(proposals, cable) -> bool:
    closest = nearest(proposals, cable)
    return bool((np.abs(closest - cable.to_array()[:4]) < [12.0, 0.1, 20.0, 0.15]).all())


def test_a_step_below_the_grain_of_the_bottom_is_found_in_a_search(draw_strip, rng):
    strip = draw_strip(FAINT, (320, 240), strip=104.0, ground=100.0)
    picture = (strip + rng.normal(0.0, 8.0, strip.shape)).astype(np.float32)
    assert is_near(propose(picture, is_searching=True), FAINT)
    assert not is_near(propose(picture), FAINT)


def test_a_smooth_strip_on_ripples_of_its_brightness_is_found_in_a_search(draw_strip, ripples, rng):
    inside = draw_strip(FAINT, (320, 240), strip=1.0, ground=0.0)
    smooth = 100.0 + rng.normal(0.0, 3.0, inside.shape)
    picture = (inside * smooth + (1.0 - inside) * ripples).astype(np.float32)
    assert is_near(propose(picture, is_searching=True), FAINT)
    assert not is_near(propose(picture), FAINT)


def test_the_proposals_of_a_search_begin_with_the_usual_ones(draw_strip):
    picture = draw_strip(CABLES[0], (320, 240))
    usual = propose(picture)
    np.testing.assert_array_equal(propose(picture, is_searching=True)[: len(usual)], usual)


def test_two_cables_are_both_proposed(draw_strip):
    pictures = [draw_strip(cable, (320, 240)) for cable in (CABLES[0], CABLES[1])]
    proposals = propose(np.maximum(*pictures))
    for cable in CABLES[:2]:
        assert abs(nearest(proposals, cable)[0] - cable.distance) < 5.0


def test_lengths_are_those_of_the_frame_not_of_the_reduced_picture(draw_strip):
    large = CableState(48.0, 0.2, 96.0, 0.03)
    found = nearest(propose(draw_strip(large, (640, 480)), 160), large)
    assert found[0] == pytest.approx(48.0, abs=12.0)
    assert found[2] == pytest.approx(96.0, abs=20.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [(16, 16), (16, 200), (300, 16), (160, 120), (2400, 16)])
@pytest.mark.parametrize("kind", ["black", "white", "noise", "one edge"])
@pytest.mark.parametrize("is_searching", [False, True])
def test_whatever_the_picture_proposals_are_plausible_cables(rng, size, kind, is_searching):
    width, height = size
    pictures = {
        "black": np.zeros((height, width)),
        "white": np.full((height, width), 255.0),
        "noise": rng.uniform(0, 255, (height, width)),
        "one edge": np.where(np.arange(width) < width // 2, 0.0, 255.0) * np.ones((height, 1)),
    }
    proposals = propose(pictures[kind].astype(np.uint8), is_searching=is_searching)
    assert proposals.shape[1:] == (4,)
    assert len(proposals) <= MOST_CABLES + 3 * MOST_FAINT
    assert np.isfinite(proposals).all()
    assert (proposals[:, 2] > 0.0).all()
    assert (np.abs(proposals[:, 3]) <= DEFAULT_LIMITS.most_skew).all()
    assert ((proposals[:, 1] > -np.pi / 2) & (proposals[:, 1] <= np.pi / 2)).all()
    if kind in ("black", "white"):
        assert len(proposals) == 0


def reference_votes(image, shape, offset_bin) -> np.ndarray:
    """Every local maximum of a strong gradient along a scan line, voting one by one."""
    votes, middle = np.zeros(shape), shape[1] // 2
    for lines, is_column in ((image.scan.rows, False), (image.scan.columns, True)):
        for gradients, place in zip(lines.gradients.astype(float), lines.places, strict=True):
            squared = gradients[:, 0] ** 2 + gradients[:, 1] ** 2
            for index in range(1, len(squared) - 1):
                before, here, after = squared[index - 1 : index + 2]
                along, across = gradients[index, :2]
                is_ridge = before <= here > after and abs(along) >= abs(across)
                if not is_ridge or here <= STRONG**2:
                    continue
                point = np.array([index - (len(squared) - 1) / 2, place])
                x, y = point[::-1] if is_column else point
                gx, gy = (across, along) if is_column else (along, across)
                nearest = round(np.arctan2(gy, gx) * ANGLE_BINS / (2 * np.pi))
                for step in range(nearest - VOTE_SPREAD, nearest + VOTE_SPREAD + 1):
                    angle = step * 2 * np.pi / ANGLE_BINS
                    column = round((x * np.cos(angle) + y * np.sin(angle)) / offset_bin)
                    votes[step % ANGLE_BINS, column + middle] += min(np.sqrt(here), VOTE_CAP)
    return votes


@pytest.mark.parametrize("size", [(160, 120), (16, 16), (16, 200), (300, 16)])
def test_every_strong_ridge_votes_near_its_direction(rng, size):
    image = plain_image(rng.normal(100, 20, size[::-1]).astype(np.float32))
    votes, offset_bin = accumulated_votes(image)
    assert votes.shape[1] % 2 == 1
    assert votes.shape[1] * offset_bin >= np.hypot(*size)
    # A vote on the edge between two bins falls to either by rounding.
    expected = reference_votes(image, votes.shape, offset_bin)
    assert np.abs(votes - expected).sum() <= 0.05 * expected.sum()
    assert expected.sum() > 0


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, -1.2])
def test_every_scan_line_votes_once_for_each_border_it_crosses(draw_strip, angle):
    image = plain_image(draw_strip(CableState(5.0, angle, 40.0), (320, 240)))
    votes, offset_bin = accumulated_votes(image)
    middle = votes.shape[1] // 2
    steep = abs(np.cos(angle)) >= abs(np.sin(angle))
    lines = image.scan.rows if steep else image.scan.columns
    for normal, offset in ((angle, 5.0 - 20.0), (angle + np.pi, -5.0 - 20.0)):
        row = round(normal / (2 * np.pi) * ANGLE_BINS) % ANGLE_BINS
        column = middle + round(offset / offset_bin)
        near = votes[row, column - 2 : column + 3].sum() / VOTE_CAP
        assert 0.6 * len(lines.places) <= near <= len(lines.places)


@pytest.mark.parametrize("width", [5.0, 180.0])
@pytest.mark.parametrize("skew", [-25.0, 25.0])
def test_wide_thin_and_skewed_cables_are_proposed_where_the_limits_let_them(
    draw_strip, width, skew
):
    cable = CableState(8.0, 0.1, width, np.deg2rad(skew) * (width > 100.0))
    image = plain_image(draw_strip(cable))
    wide = LinePairProposer(PairLimits(3.0, 240.0, np.deg2rad(30.0)), uses_map=True)
    found = nearest(wide.propose(image, is_searching=False), cable)
    assert found[0] == pytest.approx(cable.distance, abs=5.0)
    assert found[2] == pytest.approx(width, abs=6.0)
    assert found[3] == pytest.approx(cable.skew, abs=0.05)
    limited = LinePairProposer(PairLimits(8.0, 120.0, np.deg2rad(15.0)), uses_map=True)
    narrow = limited.propose(image, is_searching=True)
    assert ((narrow[:, 2] >= 8.0) & (narrow[:, 2] <= 120.0)).all()
    assert (np.abs(narrow[:, 3]) <= np.deg2rad(15.0)).all()
