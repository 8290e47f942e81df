import dataclasses
import itertools

import numpy as np
import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.sequences.frame import RawImage
from cable_tracker.simulation.scenario_dive import (
    SimulationSettings,
    simulate,
    simulate_scenario,
)
from cable_tracker.simulation.scenarios import ComponentMotion, Crossing, find_scenario
from cable_tracker.stamps import FIRST_STAMP

SMALL = SimulationSettings(frame_count=4, image_size=(96, 72), seed=11)


def _bytes(settings):
    return [bytes(frame.image.data) for frame in simulate(settings)]


def test_the_same_settings_give_the_same_frames():
    assert _bytes(SMALL) == _bytes(SMALL)


def test_a_longer_dive_has_the_same_motion():
    longer = dataclasses.replace(SMALL, frame_count=9)
    truths = [frame.truth for frame in simulate(longer)]
    assert truths[:4] == [frame.truth for frame in simulate(SMALL)]


@pytest.mark.parametrize("change", [{"seed": 12}, {"clutter": 0.6}, {"noise": 4.0}])
def test_other_settings_give_other_frames(change):
    assert _bytes(SMALL) != _bytes(dataclasses.replace(SMALL, **change))


def test_other_noise_leaves_the_motion_alone():
    quiet = dataclasses.replace(SMALL, noise=0.0, clutter=0.0)
    assert [f.truth for f in simulate(quiet)] == [f.truth for f in simulate(SMALL)]


@pytest.mark.parametrize(
    "size",
    [(320, 240), (161, 97), (97, 161), (32, 32), pytest.param((640, 480), marks=pytest.mark.slow)],
)
def test_frames_are_complete(size):
    settings = SimulationSettings(frame_count=2, image_size=size)
    for index, frame in enumerate(simulate(settings)):
        image = frame.image
        assert isinstance(image, RawImage)
        assert frame.index == index
        assert frame.frame_id == "camera"
        assert (image.encoding, image.width, image.height) == ("mono8", *size)
        assert image.step == image.width
        assert len(image.data) == image.width * image.height
        assert frame.truth is not None
        assert frame.truth.is_finite()


def test_stamps_follow_the_rate_and_are_never_zero():
    settings = dataclasses.replace(SMALL, rate=30.0)
    stamps = [frame.stamp for frame in simulate(settings)]
    assert stamps == [FIRST_STAMP + round(index * 1e9 / 30) for index in range(4)]


def test_truth_carries_velocities_per_second():
    frames = list(simulate(dataclasses.replace(SMALL, rate=1000.0)))
    for first, second in itertools.pairwise(frames):
        before, after = first.truth.to_array(), second.truth.to_array()
        steps = (after - before)[:4] * 1000
        assert (np.abs(before[4:] - steps) < (0.5, 0.02, 0.5, 0.02)).all()
        assert before[4:].all()


def test_the_cable_is_seen_in_the_picture(pixels_of):
    frame = next(simulate(SimulationSettings(frame_count=1, clutter=0.0, noise=0.0)))
    image = pixels_of(frame).astype(float)
    x, y = np.meshgrid(np.arange(320) - 159.5, 119.5 - np.arange(240))
    truth = frame.truth
    across = np.abs(x * np.cos(truth.angle) + y * np.sin(truth.angle) - truth.distance)
    near_the_middle = np.hypot(x, y) < 100
    cable = image[near_the_middle & (across < 0.2 * truth.width)]
    bottom = image[near_the_middle & (across > 1.5 * truth.width)]
    assert cable.mean() > 1.4 * bottom.mean()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"frame_count": 0}, "frame_count is 0"),
        ({"rate": 0.0}, "rate is 0"),
        ({"rate": float("nan")}, "rate is nan"),
        ({"rate": float("inf")}, "rate is inf"),
        ({"image_size": (31, 240)}, "image_size is 31x240"),
        ({"image_size": (320, 5000)}, "image_size is 320x5000"),
        ({"clutter": -0.1}, "clutter is -0.1"),
        ({"clutter": 1.1}, "clutter is 1.1"),
        ({"clutter": float("nan")}, "clutter is nan"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_values_out_of_range_are_refused(change, named):
    with pytest.raises(ParameterError, match=named) as caught:
        SimulationSettings(**change)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("event", [{"buried": (2, 4)}, {"crossing": Crossing(frame=3)}])
def test_no_cable_is_buried_or_crossed_where_none_is_in_view(event):
    calm = find_scenario("stop")
    aside = dataclasses.replace(calm.motion, distance=ComponentMotion(900.0, 0.0))
    with pytest.raises(ParameterError, match="no cable is in view"):
        simulate_scenario(dataclasses.replace(calm, motion=aside, **event))
