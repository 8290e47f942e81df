import dataclasses
from itertools import islice

import numpy as np
import pytest
from scenario_states import scenario_states

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.dive import SceneSettings, Seeds, render_dive
from cable_tracker.simulation.scenario_dive import scenario_dive, simulate_scenario
from cable_tracker.simulation.scenarios import SCENARIO_RATE, SCENARIOS, Crossing, find_scenario

THESIS_LENGTHS = {"S1": 248, "S2": 499, "S3": 409, "S4": 172, "S5": 171, "S6": 129}
SMALL = (64, 48)


def _some(name, start, stop, *, seed=0, size=SMALL, step=1):
    return list(islice(simulate_scenario(name, seed, size), start, stop, step))


def _skew_steps(name, frames):
    return np.rad2deg(np.std(np.diff(scenario_states(name)[slice(*frames), 3])))


def test_names_are_those_of_the_table():
    assert all(SCENARIOS[name].name == name for name in SCENARIOS)
    more = {"leaves", "buried", "crossing", "no_cable", "decoys", "night", "stop"}
    assert set(SCENARIOS) == set(THESIS_LENGTHS) | more


@pytest.mark.parametrize(("name", "length"), THESIS_LENGTHS.items())
def test_sequences_of_the_thesis_have_its_lengths(name, length):
    states = scenario_states(name)
    assert states.shape == (length, 8)
    assert np.isfinite(states).all()


@pytest.mark.usefixtures("undrawn")
def test_frames_are_numbered_and_complete():
    frames = list(simulate_scenario(dataclasses.replace(SCENARIOS["S6"], frame_count=35), 0, SMALL))
    assert [each.frame.index for each in frames] == list(range(35))
    assert frames[1].frame.stamp - frames[0].frame.stamp == 40_000_000


@pytest.mark.parametrize("name", ["S1", "crossing", "night"])
def test_the_same_seed_gives_the_same_frames(name):
    first, second = (_some(name, 0, 3) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        assert bytes(one.frame.image.data) == bytes(other.frame.image.data)
        assert one.frame.truth == other.frame.truth
        assert one.visibility == other.visibility
    assert first[0].frame.truth != _some(name, 0, 1, seed=1)[0].frame.truth


@pytest.mark.usefixtures("undrawn")
def test_the_truth_of_frames_is_that_of_the_geometry():
    states = scenario_states("S3", 4, SMALL)
    for each in _some("S3", 0, 40, seed=4, step=13):
        np.testing.assert_array_equal(each.frame.truth.to_array(), states[each.frame.index])


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    "name", ["S5", *(pytest.param(f"S{n}", marks=pytest.mark.slow) for n in (1, 2, 4, 6))]
)
def test_hard_sequences_hide_much_of_the_borders_but_rarely_nearly_all(name):
    frames = (each for seed in range(100, 102) for each in _some(name, 0, 121, seed=seed, step=20))
    shares = np.array([each.visibility for each in frames])
    assert 0.45 < shares.mean() < 0.85
    assert np.mean(shares > 0.35) > 0.8


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_the_calm_sequence_is_clearer_than_the_hard_ones():
    calm = np.mean([each.visibility for each in _some("S3", 0, 170, seed=100, step=10)])
    hard = np.mean([each.visibility for each in _some("S5", 0, 170, seed=100, step=10)])
    assert calm > hard + 0.1


def test_s1_wavers_at_first_and_s6_looks_forward_after_frame_20():
    assert _skew_steps("S1", (0, 105)) > 2 * _skew_steps("S1", (140, 248))
    skew = np.rad2deg(scenario_states("S6")[:, 3])
    assert skew[40:].mean() > skew[:15].mean() + 4


def test_s2_moves_rapidly_near_430():
    distance = scenario_states("S2")[:, 0]
    assert distance[440] - distance[423] > 25


def test_s4_pitches_near_70_and_125():
    skew = np.rad2deg(scenario_states("S4")[:, 3])
    assert skew[85:112].mean() > max(skew[:58].mean(), skew[140:].mean()) + 0.8


def test_s5_is_a_dark_cable_on_bright_ground():
    each = _some("S5", 0, 1, seed=100, size=(320, 240))[0]
    image = np.frombuffer(each.frame.image.data, np.uint8).reshape(240, 320).astype(float)
    x, y = np.meshgrid(np.arange(320) - 159.5, 119.5 - np.arange(240))
    truth = each.frame.truth
    across = np.abs(x * np.cos(truth.angle) + y * np.sin(truth.angle) - truth.distance)
    near = np.hypot(x, y) < 90
    bottom = image[near & (across > 1.5 * truth.width)].mean()
    assert image[near & (across < 0.2 * truth.width)].mean() < 0.75 * bottom


@pytest.mark.parametrize("seed", range(3))
def test_the_cable_leaves_the_image_and_comes_back(seed):
    seen = np.isfinite(scenario_states("leaves", seed)[:, 0])
    assert seen[:90].all()
    assert not seen[135:185].any()
    assert seen[235:].all()


@pytest.mark.usefixtures("undrawn")
def test_frames_without_the_cable_have_no_truth():
    for each in _some("leaves", 140, 180, step=20):
        assert each.frame.truth is None
        assert each.visibility == 0.0


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_the_cable_is_buried_for_three_seconds(seed):
    frames = _some("buried", 0, None, seed=seed, size=(48, 36))
    hidden = np.array([each.visibility == 0.0 for each in frames])
    assert hidden[110:185].all()
    assert 75 <= hidden.sum() <= 88
    assert all(
        (each.frame.truth is None) == gone for each, gone in zip(frames, hidden, strict=True)
    )
    assert frames[20].visibility > 0.4
    assert frames[290].visibility > 0.4


@pytest.mark.usefixtures("undrawn")
def test_without_a_cable_there_is_neither_truth_nor_visibility():
    assert np.isnan(scenario_states("no_cable")).all()
    for each in _some("no_cable", 0, 9, step=4):
        assert each.frame.truth is None
        assert each.visibility == 0.0


@pytest.mark.usefixtures("undrawn")
def test_the_crossing_hides_part_of_the_cable():
    early = dataclasses.replace(SCENARIOS["crossing"], crossing=Crossing(frame=12))
    alone = dataclasses.replace(early, crossing=None)
    one, both = (_some(each, 12, 13)[0].visibility for each in (alone, early))
    assert one - both > 0.05


def test_night_is_dark_but_for_the_middle():
    frame = _some("night", 30, 31, size=(160, 120))[0].frame
    image = np.frombuffer(frame.image.data, np.uint8).reshape(120, 160)
    assert image[:20, :20].mean() < 0.4 * image[40:80, 50:110].mean()


def test_a_stop_stands_still():
    steps = np.abs(np.diff(scenario_states("stop")[:, 0]))
    assert steps[100:165].mean() < 0.2 * steps[:60].mean()


def test_another_size_scales_lengths_only():
    small, large = scenario_states("S3", 1, (320, 240)), scenario_states("S3", 1, (640, 480))
    np.testing.assert_allclose(large[:, 1], small[:, 1], atol=1e-3)
    np.testing.assert_allclose(large[:, (0, 2)], 2 * small[:, (0, 2)], atol=0.2)


def test_a_distorted_camera_bends_the_picture_but_not_its_truth():
    size = (160, 120)
    dive, scene_settings = (
        scenario_dive("S3", 1, size),
        SceneSettings(find_scenario("S3").appearance),
    )
    camera = dataclasses.replace(dive.camera, distortion=(-0.15, 0.02, 0.0, 0.0, 0.0))
    bent, straight = (
        next(render_dive(each, scene_settings, 1, SCENARIO_RATE, Seeds.of(1)))
        for each in (dataclasses.replace(dive, camera=camera), dive)
    )
    assert bytes(bent.frame.image.data) != bytes(straight.frame.image.data)
    assert bent.frame.truth.distance == pytest.approx(straight.frame.truth.distance, abs=0.3)


def test_an_unknown_scenario_is_refused_with_the_names():
    with pytest.raises(ParameterError, match=r"scenario: 'S7' is none of S1 \| S2.*stop") as caught:
        simulate_scenario("S7")
    assert "\n" not in str(caught.value)
    with pytest.raises(ParameterError):
        find_scenario("")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [(("S1", -1), "seed is -1"), (("S1", 0, (10, 240)), "image_size is 10x240")],
)
def test_values_out_of_range_are_refused(arguments, named):
    for function in (simulate_scenario, scenario_dive):
        with pytest.raises(ParameterError, match=named):
            function(*arguments)
