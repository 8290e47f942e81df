import itertools

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError
from cable_tracker.visualisation.overlay import draw_overlay
from cable_tracker.visualisation.palette import GREEN, HYPOTHESES, PINK, RED, to_bgr

STATE = CableState(20.0, 0.2, 40.0, 0.03)
BLACK = np.zeros((240, 320), dtype=np.uint8)
SIGMA = np.array([2.0, 0.01, 2.0, 0.01])


def _near(picture, colour, tolerance=70):
    return (np.abs(picture.astype(int) - to_bgr(colour)).max(axis=2) < tolerance).astype(bool)


def _below_strip(picture):
    """Cut the status strip off, where the words are."""
    return picture[picture.shape[0] // 3 :]


def _border_distance(picture, colour, state):
    """Return the distance of coloured pixels from the nearest border or the centreline [px]."""
    height, width = picture.shape[:2]
    rows, columns = np.nonzero(_near(picture, colour) & (np.arange(height) > height / 3)[:, None])
    x, y = columns - (width - 1) / 2, (height - 1) / 2 - rows
    lines = (
        (state.angle, state.distance),
        (state.angle - state.skew, (state.distance - state.width / 2) * np.cos(state.skew)),
        (state.angle + state.skew, (state.distance + state.width / 2) * np.cos(state.skew)),
    )
    distances = [np.abs(x * np.cos(angle) + y * np.sin(angle) - rho) for angle, rho in lines]
    assert rows.size > 100
    return np.min(distances, axis=0)


@pytest.mark.parametrize("state", [STATE, CableState(-31.5, -0.5, 25.0, -0.02)])
def test_lines_are_drawn_at_the_state(state):
    picture = draw_overlay(BLACK, state=state, status="TRACKING")
    assert _border_distance(picture, GREEN, state).max() < 1.5


def test_both_borders_and_the_centreline_are_drawn():
    picture = draw_overlay(BLACK, state=CableState(0.0, 0.0, 60.0), status="TRACKING")
    row = _near(picture, GREEN)[200]
    assert row[128:132].any()
    assert row[158:162].any()
    assert row[188:192].any()
    assert row.sum() < 10


def test_enlarging_keeps_lines_in_place():
    picture = draw_overlay(BLACK, state=STATE, status="TRACKING", minimum_width=960)
    assert picture.shape == (720, 960, 3)
    large = CableState(60.0, 0.2, 120.0, 0.03)
    assert _border_distance(picture, GREEN, large).max() < 3.0


def test_numbers_stay_those_of_the_frame_when_enlarged():
    twice = cv2.resize(BLACK, (640, 480))
    large = CableState(40.0, 0.2, 80.0, 0.03)
    plain = draw_overlay(twice, state=large, status="TRACKING")
    enlarged = draw_overlay(BLACK, state=STATE, status="TRACKING", minimum_width=640)
    strip = slice(0, 60)
    assert (plain[strip] != enlarged[strip]).any()
    np.testing.assert_array_equal(plain[-200:], enlarged[-200:])


def test_a_wide_image_is_not_enlarged(grey):
    assert draw_overlay(grey, state=None, status="LOST", minimum_width=300).shape == (240, 320, 3)


def test_colour_follows_the_status():
    lost = _below_strip(draw_overlay(BLACK, state=STATE, status="LOST"))
    tracking = _below_strip(draw_overlay(BLACK, state=STATE, status="TRACKING"))
    assert _near(lost, RED).any()
    assert not _near(lost, GREEN).any()
    assert _near(tracking, GREEN).any()
    assert not _near(tracking, RED).any()


def test_the_word_has_the_colour_of_the_status():
    strips = [
        draw_overlay(BLACK, state=None, status=status)[:60]
        for status in ("TRACKING", "LOST", "INITIALISING", "REFUSED")
    ]
    for first, second in itertools.combinations(strips, 2):
        assert (first != second).any()
    assert _near(strips[0], GREEN).any()
    assert _near(strips[1], RED).any()


def test_truth_is_dashed():
    state = CableState(0.0, 0.0, 60.0)
    picture = draw_overlay(BLACK, state=None, status="LOST", truth=state)
    column = picture[60:, 128:132, to_bgr(PINK).index(255)].max(axis=1) > 60
    assert 0.3 < column.mean() < 0.8
    assert np.count_nonzero(np.diff(column.astype(int))) > 8


def test_band_has_the_width_of_two_sigma():
    state = CableState(0.0, 0.0, 100.0)
    sigma = [5.0, 0.0, 0.0, 0.0]
    with_band = draw_overlay(BLACK, state=state, status="TRACKING", sigma=sigma)
    without = draw_overlay(BLACK, state=state, status="TRACKING")
    changed = np.flatnonzero((with_band[180] != without[180]).any(axis=1))
    assert changed.min() == pytest.approx(149.5, abs=1.5)
    assert changed.max() == pytest.approx(169.5, abs=1.5)


def test_band_opens_with_the_uncertainty_of_the_angle():
    state = CableState(0.0, 0.0, 100.0)
    sigma = [1.0, 0.1, 0.0, 0.0]
    picture = draw_overlay(BLACK, state=state, status="TRACKING", sigma=sigma)
    without = draw_overlay(BLACK, state=state, status="TRACKING")
    changed = (picture != without).any(axis=2).sum(axis=1)
    assert changed[230] > 2 * changed[120]


def test_heavy_particles_are_clearer_than_light_ones():
    cloud = np.zeros((2, 9))
    cloud[:, 0] = (-60.0, 60.0)
    cloud[:, -1] = (0.99, 0.01)
    picture = draw_overlay(BLACK, state=None, status="INITIALISING", cloud=cloud).sum(axis=2)
    heavy, light = picture[150:, 95:104].max(), picture[150:, 215:224].max()
    assert heavy > 2 * light > 0


def test_only_the_heaviest_particles_are_drawn():
    rng = np.random.default_rng(0)
    heavy = np.zeros((100, 9))
    heavy[:, 0], heavy[:, -1] = rng.uniform(-100, -20, 100), 0.5
    light = heavy.copy()
    light[:, 0], light[:, -1] = rng.uniform(20, 100, 100), 0.4
    picture = draw_overlay(BLACK, state=None, status="LOST", cloud=np.vstack((light, heavy)))
    assert picture[150:, :150].any()
    assert not picture[150:, 170:].any()


def test_unusable_particles_are_left_out():
    bad = [(np.nan, 0.0, 1.0), (1e12, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, np.inf, 1.0),
           (0.0, 0.0, np.nan)]  # fmt: skip
    cloud = np.zeros((len(bad), 9))
    cloud[:, [0, 1, -1]] = bad
    picture = draw_overlay(BLACK, state=None, status="LOST", cloud=cloud)
    assert not _below_strip(picture).any()


def test_an_empty_cloud_is_nothing():
    picture = draw_overlay(BLACK, state=None, status="LOST", cloud=np.zeros((0, 9)))
    np.testing.assert_array_equal(picture, draw_overlay(BLACK, state=None, status="LOST"))


def _hypotheses(*pairs):
    return [Hypothesis(share, CableState(distance, 0.0, 30.0)) for share, distance in pairs]


def _columns(picture, colour):
    """Return the columns of the lower half in which a colour appears."""
    return set(np.flatnonzero(_near(picture[120:], colour, 40).any(axis=0)).tolist())


def test_further_hypotheses_are_centrelines_where_they_are_likely_enough():
    hypotheses = _hypotheses((0.8, 0.5), (0.12, -99.5), (0.05, 100.5), (0.03, 60.5))
    picture = draw_overlay(
        BLACK, state=CableState(0.5, 0.0, 40.0), status="TRACKING", hypotheses=hypotheses
    )
    assert _columns(picture, HYPOTHESES) == {60, 260}


@pytest.mark.parametrize(("cloud", "columns"), [(None, set()), (np.zeros((0, 9)), {60})])
def test_without_state_hypotheses_are_drawn_with_the_particles_only(cloud, columns):
    hypotheses = _hypotheses((0.8, 0.5), (0.2, -99.5))
    picture = draw_overlay(BLACK, state=None, status="LOST", cloud=cloud, hypotheses=hypotheses)
    assert _columns(picture, HYPOTHESES) == columns


def test_enlarging_keeps_hypotheses_in_place():
    hypotheses = _hypotheses((0.8, 0.0), (0.2, -99.5))
    picture = draw_overlay(
        BLACK, state=STATE, status="TRACKING", hypotheses=hypotheses, minimum_width=960
    )
    assert all(abs(column - (479.5 - 3 * 99.5)) < 3 for column in _columns(picture, HYPOTHESES))
    assert _columns(picture, HYPOTHESES)


def test_a_hypothesis_that_is_no_number_is_not_drawn():
    hypotheses = _hypotheses((0.8, 0.0), (0.2, np.nan))
    picture = draw_overlay(BLACK, state=STATE, status="TRACKING", hypotheses=hypotheses)
    np.testing.assert_array_equal(picture, draw_overlay(BLACK, state=STATE, status="TRACKING"))


def test_the_presence_stands_behind_the_status():
    strips = [
        draw_overlay(BLACK, state=None, status="TRACKING", presence=presence)[:30]
        for presence in (None, 0.976, 0.98, 0.12)
    ]
    assert (strips[0] != strips[1]).any()
    np.testing.assert_array_equal(strips[1], strips[2])
    assert (strips[2] != strips[3]).any()


def test_the_frame_itself_is_not_changed(grey):
    colour = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)
    kept = colour.copy()
    draw_overlay(colour, state=STATE, status="TRACKING", sigma=SIGMA, caption="frame 1")
    np.testing.assert_array_equal(colour, kept)


def test_the_picture_is_seen_between_the_lines(grey):
    picture = draw_overlay(grey, state=STATE, status="TRACKING", sigma=SIGMA)
    np.testing.assert_array_equal(picture[230, :60], np.repeat(grey[230, :60, None], 3, axis=1))


def test_floating_point_grey_is_shown_as_it_is(grey):
    expected = draw_overlay(grey, state=STATE, status="TRACKING")
    real = draw_overlay(grey.astype(np.float32), state=STATE, status="TRACKING")
    np.testing.assert_array_equal(real, expected)


def test_a_picture_of_finer_steps_that_uses_few_levels_is_not_drawn_black(grey):
    picture = draw_overlay(grey.astype(np.float32) / 64.0, state=None, status="LOST")
    assert np.median(picture) > 15


def test_values_out_of_range_are_clipped():
    wild = np.full((60, 80), np.nan, dtype=np.float32)
    wild[:, :40] = 1e9
    picture = draw_overlay(wild, state=None, status="LOST")
    assert (picture[-5:, :40] == 255).all()
    assert (picture[-5:, 40:] == 0).all()


def test_rows_of_a_larger_array_may_be_given(grey):
    wide = np.hstack((grey, grey))
    picture = draw_overlay(wide[:, :320], state=STATE, status="TRACKING")
    np.testing.assert_array_equal(picture, draw_overlay(grey, state=STATE, status="TRACKING"))


def test_caption_is_written_below(grey):
    plain = draw_overlay(grey, state=None, status="LOST")
    captioned = draw_overlay(grey, state=None, status="LOST", caption="frame 12  0.480 s")
    rows = np.flatnonzero((plain != captioned).any(axis=(1, 2)))
    assert rows.min() > 200


@pytest.mark.parametrize("size", [(320, 240), (1920, 1080), (640, 480), (161, 97)])
def test_words_fit_into_every_size(size):
    dark = np.zeros((size[1], size[0]), dtype=np.uint8)
    picture = draw_overlay(
        dark,
        state=CableState(-888.8, -1.5, 888.8, -0.5),
        status="INITIALISING",
        presence=1.0,
        caption="frame 0",
    )
    written = picture[: size[1] // 3].max(axis=2) > 150
    columns = np.flatnonzero(written.any(axis=0))
    assert columns.max() < size[0] - 1
    assert columns.max() > 0.6 * size[0]


DEVIATIONS = st.one_of(st.floats(min_value=0), st.just(np.nan))


@settings(max_examples=60)
@given(
    st.builds(
        CableState,
        st.floats(-1e6, 1e6),
        st.floats(-1.57, 1.57),
        st.floats(-1e6, 1e6),
        st.floats(-1.5, 1.5),
    ),
    st.tuples(DEVIATIONS, DEVIATIONS, DEVIATIONS, DEVIATIONS),
    st.sampled_from([(1, 1), (7, 5), (64, 48), (48, 64)]),
)
def test_no_state_breaks_it(state, sigma, size):
    image = np.zeros(size, dtype=np.uint8)
    picture = draw_overlay(image, state=state, status="TRACKING", sigma=sigma, truth=state)
    assert picture.shape == (*size, 3)


def test_a_state_that_is_no_number_is_not_drawn():
    nothing = draw_overlay(BLACK, state=None, status="LOST")
    broken = draw_overlay(BLACK, state=CableState(np.nan, 0.0, 10.0), status="LOST")
    np.testing.assert_array_equal(nothing, broken)


@pytest.mark.parametrize("shape", [(0, 0), (5,), (4, 4, 4), (4, 4, 1), (2, 4, 4, 3)])
def test_an_array_that_is_no_image_is_refused(shape):
    with pytest.raises(FrameError, match="image: shape is"):
        draw_overlay(np.zeros(shape, dtype=np.uint8), state=None, status="LOST")


def test_a_cloud_without_weights_is_refused():
    with pytest.raises(FrameError, match="cloud: shape is"):
        draw_overlay(BLACK, state=None, status="LOST", cloud=np.zeros((3, 8)))
