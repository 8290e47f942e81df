from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.measure.response_table import load_table
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.estimate import TrackingStatus
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.bootstrap_engine import BootstrapEngine
from cable_tracker.tracking.status import StatusMachine

STRIP = CableState(12.0, 0.2, 24.0, 0.03)
MODELS = {
    "responses": preset("thesis"),
    "likelihood_ratio": TrackerParameters(filter="bootstrap"),
}


def engine(parameters) -> BootstrapEngine:
    return BootstrapEngine(parameters, load_table(""), np.random.default_rng(1))


def cloud(count=400) -> np.ndarray:
    sigma = np.array([2.0, 0.03, 2.0, 0.02, 5.0, 0.05, 0.0, 0.0])
    return STRIP.to_array() + np.random.default_rng(0).standard_normal((count, 8)) * sigma


@pytest.mark.parametrize("model", MODELS)
def test_a_cable_rises_and_holds_and_a_flat_picture_does_not(draw_strip, model):
    picture = draw_strip(STRIP, (160, 120))
    finding = engine(MODELS[model]).start(
        cloud(), make_working_image(picture, 320), StatusMachine()
    )
    assert finding.rises
    assert finding.holds
    assert finding.presence is None
    assert len(finding.hypotheses) == 1
    assert finding.mean[0] == pytest.approx(12.0, abs=2.0)
    flat = make_working_image(np.full_like(picture, 90), 320)
    finding = engine(MODELS[model]).start(cloud(), flat, StatusMachine())
    assert not finding.rises
    assert not finding.holds


@pytest.mark.parametrize(
    ("status", "searches"),
    [
        (StatusMachine(unclaimed_time=0.5), False),
        (StatusMachine(unclaimed_time=1.5), True),
        (StatusMachine(TrackingStatus.LOST, unclaimed_time=1.5), True),
        (StatusMachine(TrackingStatus.TRACKING, unclaimed_time=1.5), False),
        (StatusMachine(contrary_time=0.1, unclaimed_time=1.5), False),
    ],
)
def test_a_search_begins_when_none_is_claimed_for_long(noise_picture, status, searches):
    parameters = preset("thesis").replaced({"search_time": 1.0})
    image = make_working_image(noise_picture(1), 320)
    tracked = engine(parameters)
    tracked.start(cloud(), image, StatusMachine())
    finding = tracked.advance(image, 0.04, status)
    assert (tracked.particles.states[:, 0].std() > 20.0) == searches
    assert (finding.status.unclaimed_time == 0.0) == searches or status.unclaimed_time == 0.0
