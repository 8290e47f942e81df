from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from cable_tracker.target.measure.outline import find_outline
from cable_tracker.target.measure.region import measure_frame
from cable_tracker.target.measure.working_frame import make_working_frame
from cable_tracker.target.model.predicted_density import Births
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.known_target import (
    FIRST_GREY_LIKENESS,
    KnownTarget,
    UsualScore,
    adapted_to_contour,
    contour_histograms,
    learn_target,
    relearnt,
)


def pose(log_scale):
    return np.array([3.0, 4.0, log_scale, 0.1, 0.0, 0.0])


@pytest.fixture
def known():
    score = UsualScore(1.0, 0.1)
    births = Births(pose(0.0), 2.0, (240, 320))
    looks = SimpleNamespace(size=20.0), SimpleNamespace(bins=SimpleNamespace(shape=(4, 4, 1)))
    return KnownTarget(*looks, score, score, 0.5, births)


def test_the_usual_size_is_the_likeliest_and_the_others_less_so_the_shorter_it_is_away(known):
    states = np.stack((pose(0.5), pose(0.9)))
    away = known.log_size_factor(states, 0.1)
    in_view = known.with_last_pose(pose(0.5)).log_size_factor(states, 0.1)
    assert away[0] == in_view[0] == 0.0
    assert in_view[1] < away[1] < 0.0


def test_the_usual_size_follows_by_a_share(known):
    assert known.with_size(pose(1.0), 0.1).usual_log_scale == pytest.approx(0.55)


def test_where_it_was_seen_it_may_come_again(known):
    births = known.with_last_pose(pose(0.2)).births
    assert births.seconds == 0.0
    np.testing.assert_array_equal(births.last, pose(0.2))


PARAMETERS = TargetParameters()


def learnt(image, mask):
    frame = make_working_frame(image, 320)
    known, _ = learn_target(frame, mask, PARAMETERS, is_exact=True)
    return known, known.births.last


def test_what_a_target_shows_in_grey_is_learnt_where_it_is(draw):
    image, mask = draw()
    known, state = learnt(image, mask)
    known = replace(known, usual_likeness=UsualScore(0.5, 0.2))
    grey = make_working_frame(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), 320)
    anew = relearnt(known, state, grey, PARAMETERS)
    assert not anew.is_coloured
    assert anew.usual_likeness == FIRST_GREY_LIKENESS
    assert anew.usual.mean > 0.0


@pytest.mark.parametrize("x", [60.0, 900.0])
def test_nothing_is_learnt_anew_where_the_target_is_not(draw, x):
    image, mask = draw()
    known, state = learnt(image, mask)
    grey = make_working_frame(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), 320)
    elsewhere = state + np.array([x, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert relearnt(known, elsewhere, grey, PARAMETERS) is known


def test_what_is_learnt_in_a_time_does_not_depend_on_the_frames_in_it(draw):
    image, mask = draw()
    known, state = learnt(image, mask)
    measured = measure_frame(make_working_frame(draw(seed=1)[0], 320), known.appearance, PARAMETERS)
    outline = find_outline(measured.ratios, state, known.template, 0.1, PARAMETERS)
    shown = contour_histograms(outline, measured, known, PARAMETERS)

    def after(frames, dt):
        later = known
        for _ in range(frames):
            later = adapted_to_contour(
                later, outline, shown, PARAMETERS, dt=dt, angle=0.0, score=1.0
            )
        return later

    once, often = after(1, 0.12), after(3, 0.04)
    assert once.appearance.target == pytest.approx(often.appearance.target)
    assert once.appearance.surroundings == pytest.approx(often.appearance.surroundings)
    # The first frame reshapes as if it were due; after it comes every third.
    early, late = after(4, 0.04), after(4, 0.08)
    assert np.abs(late.template.distances - known.template.distances).sum() > (
        np.abs(early.template.distances - known.template.distances).sum()
    )


def test_after_a_pause_one_frame_does_not_outweigh_all_before(draw):
    image, mask = draw()
    known, state = learnt(image, mask)
    measured = measure_frame(make_working_frame(draw(seed=1)[0], 320), known.appearance, PARAMETERS)
    outline = find_outline(measured.ratios, state, known.template, 0.1, PARAMETERS)
    shown = contour_histograms(outline, measured, known, PARAMETERS)
    other = replace(shown, target=np.roll(shown.target, 3))
    paused = adapted_to_contour(
        known, outline, other, PARAMETERS, dt=4.9, angle=0.0, score=known.usual.mean
    )
    kept = np.abs(paused.appearance.target - other.target).sum()
    assert kept > 0.5 * np.abs(known.appearance.target - other.target).sum()


def test_what_goes_on_beyond_the_marked_box_is_not_taken_for_the_target():
    # A dark bar across the picture, of which only a part is marked.
    noise = np.random.default_rng(1).normal(0.0, 3.0, (240, 320))
    picture = np.full((240, 320), 120.0)
    picture[100:140] = 60.0
    frame = make_working_frame(np.clip(picture + noise, 0, 255).astype(np.uint8), 320)
    marked = np.zeros((240, 320), np.bool_)
    marked[100:140, 140:180] = True
    known, _ = learn_target(frame, marked, TargetParameters(), is_exact=False)
    half_width, half_height = (each * known.template.size for each in known.template.extent(0.0))
    assert half_width < 20.0 * 1.3 + 2.0
    assert 17.0 < half_height < 23.0
