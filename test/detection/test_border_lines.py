from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.border_lines import (
    GRADIENT_FLOOR,
    fit_lines,
    gradient_of,
    gradient_ridge,
    magnitude,
    turn_between,
)
from cable_tracker.detection.search_region import SearchRegion

SIZE = (320, 240)


def slope(angle: float, steepness: float, size=(60, 50)) -> np.ndarray:
    width, height = size
    x, y = np.arange(width)[None, :], -np.arange(height)[:, None]
    return (100.0 + steepness * (x * np.cos(angle) + y * np.sin(angle))).astype(np.float32)


@pytest.mark.parametrize("degrees", [0, 30, 90, 200, 300])
def test_the_gradient_of_a_slope_points_up_it_with_y_up(degrees):
    angle = np.deg2rad(degrees)
    gradient = gradient_of(slope(angle, 2.0))
    np.testing.assert_allclose(gradient.x[5:-5, 5:-5], 2.0 * np.cos(angle), atol=1e-4)
    np.testing.assert_allclose(gradient.y[5:-5, 5:-5], 2.0 * np.sin(angle), atol=1e-4)
    np.testing.assert_allclose(gradient.modulus[5:-5, 5:-5], 2.0, atol=1e-4)


def test_the_scale_is_the_sigma_of_gaussian_components(rng):
    noise = rng.normal(0.0, 5.0, (240, 320)).astype(np.float32)
    gradient = gradient_of(noise)
    assert gradient.scale == pytest.approx(float(gradient.x.std()), rel=0.05)


def test_the_scale_of_a_flat_picture_is_the_floor():
    assert gradient_of(np.full((40, 40), 9.0, np.float32)).scale == GRADIENT_FLOOR


def test_the_ridge_follows_the_border(draw_strip):
    image = draw_strip(CableState(0.0, 0.0, 41.0)).astype(np.float32)
    gradient = gradient_of(image)
    ridge = gradient_ridge(gradient) & (gradient.modulus > 10)
    # The borders lie at the columns 159.5 - 20.5 and 159.5 + 20.5.
    np.testing.assert_array_equal(np.nonzero(ridge[100])[0], [139, 180])


def test_points_within_a_region_are_those_it_covers(edge_line, join):
    near, far = edge_line(0.0, 10.0, -20.0, 20.0), edge_line(0.0, 90.0, -20.0, 20.0)
    region = SearchRegion(CableState(10.0, 0.0, 20.0), distance=5.0, angle=0.1, width=5.0)
    both = join(near, far)
    assert len(both.within(region)) == len(near)
    assert both.within(None) is both


def test_equal_vectors_are_equally_long_wherever_they_lie_in_memory():
    rng = np.random.default_rng(5)
    x, y = (rng.normal(size=(123, 157)).astype(np.float32) for _ in range(2))
    expected = magnitude(x, y)
    np.testing.assert_allclose(expected, np.hypot(x, y), rtol=1e-6)
    for size in rng.integers(1, 5000, 40):
        moved = np.zeros(size + x.size, np.float32)[size:].reshape(x.shape)
        moved[...] = x
        np.testing.assert_array_equal(magnitude(moved, y), expected)


def fit(points, *seeds):
    angles, offsets = np.array(seeds, dtype=float).T
    return fit_lines(angles, offsets, points, SIZE)


@given(angle=st.floats(-np.pi, np.pi), offset=st.floats(-60, 60))
def test_a_line_is_drawn_to_its_points(edge_line_of, angle, offset):
    lines = fit(edge_line_of(angle, offset), (angle + 0.02, offset + 1.0))
    assert turn_between(lines.angles, np.array([angle]))[0] == pytest.approx(0.0, abs=1e-6)
    assert lines.offsets[0] == pytest.approx(offset, abs=1e-6)


@pytest.fixture(scope="module")
def edge_line_of():
    """The maker of points, for tests that hypothesis calls many times."""
    from cable_tracker.detection.border_lines import EdgePoints  # noqa: PLC0415

    def make(angle: float, offset: float) -> EdgePoints:
        along = np.arange(-100.0, 100.0)[:, None]
        normal = np.array([np.cos(angle), np.sin(angle)])
        up = np.array([-np.sin(angle), np.cos(angle)])
        return EdgePoints(offset * normal + along * up, np.full(200, angle), np.full(200, 6.0))

    return make


def test_points_that_brighten_the_other_way_do_not_belong(edge_line):
    assert len(fit(edge_line(np.pi, 0.0), (0.0, 0.0))) == 0


def test_too_few_points_give_no_line(edge_line):
    assert len(fit(edge_line(0.0, 20.0, 0.0, 5.0), (0.0, 20.0))) == 0


def test_two_guesses_of_one_line_become_one(edge_line):
    assert len(fit(edge_line(0.3, 20.0), (0.3, 21.0), (0.32, 19.0))) == 1


def test_lines_apart_stay_two_and_the_better_supported_is_first(edge_line, join):
    points = join(edge_line(0.0, -40.0, -30.0, 30.0), edge_line(0.0, 40.0))
    lines = fit(points, (0.0, -40.0), (0.0, 40.0))
    np.testing.assert_allclose(lines.offsets, [40.0, -40.0], atol=1e-9)


def test_the_support_is_the_share_of_the_line_that_is_covered(edge_line):
    whole = fit(edge_line(0.0, 20.0, -119.0, 120.0), (0.0, 20.0)).supports[0]
    half = fit(edge_line(0.0, 20.0, 0.0, 120.0), (0.0, 20.0)).supports[0]
    faint = fit(edge_line(0.0, 20.0, -119.0, 120.0, contrast=3.0), (0.0, 20.0)).supports[0]
    assert whole == pytest.approx(1.0, abs=0.02)
    assert half == pytest.approx(0.5, abs=0.02)
    assert faint == pytest.approx(0.5, abs=0.02)


def test_a_short_line_in_a_corner_is_not_well_supported(edge_line):
    # At 45 degrees and 190 px from the centre, about 15 px of the line are inside.
    points = edge_line(np.pi / 4, 190.0, -27.0, -10.0)
    assert fit(points, (np.pi / 4, 190.0)).supports[0] < 0.25


@pytest.mark.parametrize(
    ("to", "start", "turn"), [(0.1, 0.0, 0.1), (3.1, -3.1, 6.2 - 2 * np.pi), (7.0, 7.0, 0.0)]
)
def test_turns_go_the_short_way(to, start, turn):
    assert turn_between(np.array(to), np.array(start)) == pytest.approx(turn)
