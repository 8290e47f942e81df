from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pair_proposer import (
    ANGLE_BINS,
    ANGLE_MARGIN,
    MOST_CABLES,
    STRONG,
    VOTE_CAP,
    VOTE_SPREAD,
    LinePairProposer,
    accumulated_votes,
    accumulator_layout,
    clearness_of,
    strongest_lines,
)
from cable_tracker.detection.pair_limits import DEFAULT_LIMITS, PairLimits

CABLES = [
    CableState(12.0, 0.2, 24.0, 0.03),
    CableState(-30.0, -0.6, 16.0),
    CableState(10.0, np.pi / 2, 30.0),
    CableState(-10.0, -np.pi / 2 + 0.03, 30.0),
    CableState(0.0, 0.8, 40.0, -0.06),
]


def propose(image, working_width=320) -> np.ndarray:
    return LinePairProposer().propose(make_working_image(image, working_width))


def nearest(proposals, truth) -> np.ndarray:
    """The proposal with the nearest d, in the chart of the truth, shape (4,)."""
    states = np.zeros((len(proposals), 8))
    states[:, :4] = proposals
    chart = unwrap_states(states, truth.angle)[:, :4]
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
@pytest.mark.parametrize("size", [(16, 16), (16, 200), (300, 16), (160, 120)])
@pytest.mark.parametrize("kind", ["black", "white", "noise", "one edge"])
def test_whatever_the_picture_proposals_are_plausible_cables(rng, size, kind):
    width, height = size
    pictures = {
        "black": np.zeros((height, width)),
        "white": np.full((height, width), 255.0),
        "noise": rng.uniform(0, 255, (height, width)),
        "one edge": np.where(np.arange(width) < width // 2, 0.0, 255.0) * np.ones((height, 1)),
    }
    proposals = propose(pictures[kind].astype(np.uint8))
    assert proposals.shape[1:] == (4,)
    assert len(proposals) <= MOST_CABLES
    assert np.isfinite(proposals).all()
    assert (proposals[:, 2] > 0.0).all()
    assert (np.abs(proposals[:, 3]) <= DEFAULT_LIMITS.most_skew).all()
    assert ((proposals[:, 1] > -np.pi / 2) & (proposals[:, 1] <= np.pi / 2)).all()
    if kind in ("black", "white"):
        assert len(proposals) == 0


def reference_votes(image) -> np.ndarray:
    """Every local maximum of a strong gradient along a scan line, voting one by one."""
    offset_bin, middle = accumulator_layout(image)
    votes = np.zeros((ANGLE_BINS, 2 * middle + 1))
    for lines, is_column in ((image.scanned.rows, False), (image.scanned.columns, True)):
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
    image = make_working_image(rng.normal(100, 20, size[::-1]).astype(np.float32), 320)
    votes = accumulated_votes(image)
    margin = ANGLE_MARGIN
    # A vote on the edge between two bins falls to either by rounding.
    expected = reference_votes(image)
    moved = np.abs(votes[margin:-margin] - expected).sum()
    assert moved <= 0.05 * expected.sum()
    assert expected.sum() > 0
    np.testing.assert_array_equal(votes[:margin], votes[-2 * margin : -margin])
    np.testing.assert_array_equal(votes[-margin:], votes[margin : 2 * margin])


def test_a_line_across_ripples_is_clearer_than_the_ripples(rng):
    votes = rng.exponential(1.0, (30, 41)).astype(np.float32)
    votes[10] += 30.0 * rng.random(41).astype(np.float32)
    votes[20, 15] += 20.0
    clear = clearness_of(votes)
    assert votes[10].max() > votes[20, 15]
    assert np.unravel_index(clear.argmax(), clear.shape) == (20, 15)
    assert (clear >= 0.0).all()


@given(row=st.floats(4.0, 20.0), column=st.floats(4.0, 36.0))
def test_a_peak_is_told_between_its_bins(row, column):
    rows, columns = np.mgrid[:30, :41]
    votes = np.exp(-0.5 * ((rows - row) ** 2 + (columns - column) ** 2) / 1.5**2)
    angles, offsets, supports = strongest_lines(votes.astype(np.float32), 3.0, 20, 24)
    assert angles[0] == pytest.approx((row - ANGLE_MARGIN) * 2 * np.pi / ANGLE_BINS, abs=0.02)
    assert offsets[0] == pytest.approx((column - 20) * 3.0, abs=0.6)
    assert supports[0] == supports.max() > 0.0


def test_the_clearest_lines_come_first_and_no_more_than_asked_for(rng):
    votes = rng.exponential(1.0, (40, 31)).astype(np.float32)
    few, many = (strongest_lines(votes, 3.0, 15, most)[2] for most in (5, 1000))
    assert (np.diff(many) <= 0.0).all()
    np.testing.assert_array_equal(few, many[:5])


def test_a_frame_without_votes_has_no_lines():
    assert all(len(each) == 0 for each in strongest_lines(np.zeros((40, 31)), 3.0, 15, 24))


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, -1.2])
def test_every_scan_line_votes_once_for_each_border_it_crosses(draw_strip, angle):
    image = make_working_image(draw_strip(CableState(5.0, angle, 40.0), (320, 240)), 320)
    votes = accumulated_votes(image)
    offset_bin, middle = accumulator_layout(image)
    steep = abs(np.cos(angle)) >= abs(np.sin(angle))
    lines = image.scanned.rows if steep else image.scanned.columns
    for normal, offset in ((angle, 5.0 - 20.0), (angle + np.pi, -5.0 - 20.0)):
        row = round(normal / (2 * np.pi) * ANGLE_BINS) % ANGLE_BINS + ANGLE_MARGIN
        column = middle + round(offset / offset_bin)
        near = votes[row, column - 2 : column + 3].sum() / VOTE_CAP
        assert 0.6 * len(lines.places) <= near <= len(lines.places)


@pytest.mark.parametrize("width", [5.0, 180.0])
@pytest.mark.parametrize("skew", [-25.0, 25.0])
def test_wide_thin_and_skewed_cables_are_proposed_where_the_limits_let_them(
    draw_strip, width, skew
):
    cable = CableState(8.0, 0.1, width, np.deg2rad(skew) * (width > 100.0))
    image = make_working_image(draw_strip(cable), 320)
    wide = LinePairProposer(PairLimits(3.0, 240.0, np.deg2rad(30.0)))
    found = nearest(wide.propose(image), cable)
    assert found[0] == pytest.approx(cable.distance, abs=5.0)
    assert found[2] == pytest.approx(width, abs=6.0)
    assert found[3] == pytest.approx(cable.skew, abs=0.05)
    narrow = LinePairProposer(PairLimits(8.0, 120.0, np.deg2rad(15.0))).propose(image)
    assert ((narrow[:, 2] >= 8.0) & (narrow[:, 2] <= 120.0)).all()
    assert (np.abs(narrow[:, 3]) <= np.deg2rad(15.0)).all()
