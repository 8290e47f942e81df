from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numba.core import event
from plain_images import plain_image

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME, TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.detection.line_pair_proposer import LinePairProposer
from cable_tracker.errors import ParameterError
from cable_tracker.trackers import CableTracker, make_proposer, make_tracker, warm_up


def test_every_detector_that_can_be_named_can_be_made():
    assert set(PARAMETERS_BY_NAME["detector"].choices) == {"none", "line_pairs"}
    assert make_proposer(TrackerParameters(detector="none")) is None
    parameters = TrackerParameters(detector="line_pairs")
    assert isinstance(make_proposer(parameters), LinePairProposer)


def test_the_bootstrap_filter_asks_no_detector():
    parameters = TrackerParameters(detector="line_pairs", filter="bootstrap")
    assert make_proposer(parameters) is None


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_makes_a_tracker(name):
    tracker = make_tracker(PRESETS[name])
    estimate = tracker.process(np.zeros((20, 20), np.uint8), 1)
    assert tracker.parameters is PRESETS[name]
    assert estimate.stamp == 1


def stripe() -> np.ndarray:
    """An upright stripe, 30 px right of the middle and 20 px wide."""
    x = np.arange(160) - 79.5
    row = 100.0 + 60.0 * (np.abs(x - 30.0) < 10.0)
    noise = np.random.default_rng(0).normal(0.0, 4.0, (120, 160))
    return np.clip(row + noise, 0, 255).astype(np.uint8)


def test_the_detector_proposes_cables_as_wide_as_the_parameters_allow():
    picture = np.full((240, 320), 90, np.uint8)
    picture[:, 60:270] = 160
    image = plain_image(picture)
    wide = TrackerParameters(width_maximum=240.0)
    narrow = TrackerParameters(width_maximum=150.0)
    assert (make_proposer(wide).propose(image, is_searching=False)[:, 2] > 200.0).any()
    assert not (make_proposer(narrow).propose(image, is_searching=False)[:, 2] > 150.0).any()


def share_at_the_stripe(tracker) -> float:
    """Share of the particles that are at the stripe, after one frame."""
    tracker.process(stripe(), 1)
    distances = tracker.particles.states[:, 0] * np.cos(tracker.particles.states[:, 1])
    return float((np.abs(distances - 30.0) < 5.0).mean())


@pytest.mark.parametrize("make", [CableTracker, make_tracker])
def test_the_detector_that_is_named_is_the_one_that_is_asked(make):
    shares = {"detector_share": 0.3, "particle_count": 60}
    found = {}
    for detector in ("none", "line_pairs"):
        tracker = make(TrackerParameters(detector=detector, **shares))
        found[detector] = share_at_the_stripe(tracker)
    assert found["line_pairs"] > found["none"] + 0.15


@pytest.mark.parametrize("detector", ["none", "line_pairs"])
def test_a_detector_that_is_named_later_is_the_one_that_is_asked_from_then_on(detector):
    """A tracker that has seen nothing takes any parameters as if it had been made with them."""
    parameters = TrackerParameters(detector=detector, detector_share=0.3, particle_count=60)
    other = {"none": "line_pairs", "line_pairs": "none"}[detector]
    tracker = CableTracker(parameters.replaced({"detector": other}))
    tracker.configure(parameters)
    assert share_at_the_stripe(tracker) == share_at_the_stripe(CableTracker(parameters))


def test_an_unreadable_table_is_refused():
    with pytest.raises(ParameterError, match="response_table"):
        make_tracker(TrackerParameters(response_table="no such file.json"))


@pytest.mark.parametrize("name", PRESETS)
def test_after_a_warm_up_no_kind_of_frame_is_compiled_for(name):
    """Levels of either type, and of messages, which cannot be written to; in a search, and told."""
    warm_up(PRESETS[name])
    compiled: list[str] = []

    class Compilations(event.Listener):
        def on_start(self, event):
            pass

        def on_end(self, event):
            compiled.append(str(event.data["dispatcher"]))

    listener = Compilations()
    event.register("numba:compile", listener)
    try:
        for dtype, writable in product((np.uint8, np.float32), (True, False)):
            tracker, frame = make_tracker(PRESETS[name]), stripe().astype(dtype)
            frame.setflags(write=writable)
            for number in range(1, 7):
                if number == 4:
                    tracker.initialise(GivenState.around(CableState(30.0, 0.0, 20.0)))
                tracker.process(frame, stamp=number * 40_000_000)
    finally:
        event.unregister("numba:compile", listener)
    assert compiled == []
