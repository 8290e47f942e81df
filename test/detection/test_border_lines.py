from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.detection.border_lines import fit_lines, turn_between

SIZE = (320, 240)


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
    from cable_tracker.detection.edges import EdgePoints  # noqa: PLC0415

    def make(angle: float, offset: float) -> EdgePoints:
        along = np.arange(-100.0, 100.0)[:, None]
        normal = np.array([np.cos(angle), np.sin(angle)])
        up = np.array([-np.sin(angle), np.cos(angle)])
        return EdgePoints(offset * normal + along * up, np.full(200, angle), np.full(200, 6.0))

    return make


def test_points_that_brighten_the_other_way_do_not_belong(edge_line):
    assert len(fit(edge_line(np.pi, 0.0), (0.0, 0.0))) == 0


def test_a_line_through_too_few_points_is_none(edge_line):
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
