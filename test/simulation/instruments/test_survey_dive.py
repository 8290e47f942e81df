import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.instruments.survey_dive import (
    TICKS,
    SurveyDive,
    SurveyDiveSettings,
    meetings,
    usual_survey,
)
from cable_tracker.simulation.rendering.clutter import Streak
from cable_tracker.simulation.rendering.tube import Bend, Tube
from cable_tracker.simulation.seen_cable import cable_of_seed, cable_points

SMALL = SurveyDiveSettings(seed=3, length=4.0, image_size=(64, 48), rate=5.0)


def test_every_manieth_tick_has_a_picture_and_an_altitude():
    ticks = list(islice(SurveyDive(SMALL).ticks(), 3 * TICKS))
    assert [tick.picture is not None for tick in ticks] == ([True] + [False] * (TICKS - 1)) * 3
    assert all((tick.altitude is None) == (tick.picture is None) for tick in ticks)


def test_the_vehicle_stays_over_the_cable_to_its_end():
    ticks = list(SurveyDive(SMALL).ticks())
    tube = cable_of_seed(SMALL.cable_seed)
    course = cable_points(tube, np.arange(-3.0, 8.0, 0.05))[0][:, :2]
    for tick in ticks:
        away = np.hypot(*(course - tick.state.position[:2]).T).min()
        assert away < 0.6
    assert ticks[-1].state.position[0] > SMALL.length - 0.5


def test_the_rates_of_the_truth_are_the_slope_of_its_places():
    dive = SurveyDive(replace(SMALL, length=1.5, rate=25.0))
    truths = [tick.truth for tick in dive.ticks() if tick.truth is not None]
    states = np.array([truth.to_array() for truth in truths])
    slopes = (states[2:, :4] - states[:-2, :4]) * 12.5
    # The vehicle is pushed in between, too.
    spread = slopes.std(axis=0)
    assert (np.abs(states[1:-1, 4:] - slopes).max(axis=0) < 0.3 * spread).all()


def test_dives_over_one_cable_differ_in_all_but_the_cable():
    first, second = (next(SurveyDive(replace(SMALL, seed=seed)).ticks()) for seed in (1, 2))
    assert not np.array_equal(first.imu.angles, second.imu.angles)
    np.testing.assert_array_equal(first.state.position, second.state.position)


def test_the_same_seed_gives_the_same_dive():
    first, second = (list(islice(SurveyDive(SMALL).ticks(), 6)) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.odometry.position, b.odometry.position)


def test_a_usual_survey_has_a_burial_in_50_m_and_a_crossing_in_100_m():
    settings = usual_survey(200.0, seed=5)
    assert len(settings.buried) == 4 and len(settings.crossings) == 2
    assert all(0 < each.end - each.start < 10 for each in settings.buried)
    assert usual_survey(200.0, seed=6).buried == settings.buried


@pytest.mark.parametrize(
    "wrong",
    [
        {"length": 0.0},
        {"altitude": 0.0},
        {"speed": math.inf},
        {"rate": 0.0},
        {"seed": -1},
        {"current": -0.1},
        {"wander": math.nan},
        {"excursion": math.inf},
    ],
)
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ParameterError):
        SurveyDiveSettings(**wrong)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [((math.nan, 0), "length"), ((math.inf, 0), "length"), ((200.0, 0, -1), "cable_seed is -1")],
)
def test_a_usual_survey_that_cannot_be_is_refused_in_words(wrong, words):
    with pytest.raises(ParameterError, match=words):
        usual_survey(*wrong)


BENT = Tube(0.08, (Bend(1.0, 0.2, 0.3),))


def rope(angle: float, beside: float = 0.0, half_length: float = 30.0) -> Streak:
    """Return a rope whose middle lies 5 m along the cable, turned from it [deg], [radii]."""
    (point,), (direction,) = BENT.axis(np.array([5.0]))
    turn = math.atan2(-direction[0], direction[1]) + math.radians(angle)
    p, q = point[:2] / BENT.radius
    return Streak(
        p + beside, q, turn, half_width=0.1, half_length=half_length, tone=0.2, opacity=0.8,
        twist=0.0, on_top=True,
    )  # fmt: skip


@pytest.mark.parametrize("angle", [40.0, -70.0])
def test_a_rope_meets_the_bent_cable_where_that_runs(angle):
    lying = rope(angle)
    away = -7.0 * math.sin(lying.angle), 7.0 * math.cos(lying.angle)
    shifted = replace(lying, p=lying.p + away[0], q=lying.q + away[1])
    assert meetings(BENT, shifted) == pytest.approx([5.0], abs=0.002)


def test_a_rope_that_ends_before_the_cable_or_runs_along_it_does_not_lie_across():
    assert meetings(BENT, rope(90.0, beside=12.0, half_length=6.0)).size == 0
    assert meetings(BENT, rope(5.0)).size == 0


def test_other_cables_are_among_the_lines_across_in_their_order():
    settings = SurveyDiveSettings(seed=3, cable_seed=4, length=60.0, crossings=(31.0,))
    across = SurveyDive(settings).lines_across()
    assert 31.0 in across and len(across) > 1
    assert (np.diff(across) >= 0.0).all()
