from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.evidence import NOISE_FLOOR, border_evidence, response_scale
from cable_tracker.cable.thesis.observation import BorderObservation

TRUE = CableState(15.0, 0.2, 50.0, 0.05)
PARAMETERS = preset("thesis")
MODEL = BorderObservation(PARAMETERS)


def evidence(image, state=TRUE) -> float:
    return border_evidence(MODEL, state.to_array(), make_working_image(image, 320))


def test_a_clear_strip_is_far_above_the_threshold(draw_strip, noise_picture):
    image = draw_strip(TRUE).astype(np.float32)
    assert evidence(image) > 10 * PARAMETERS.evidence_to_track
    noise = noise_picture(1, (320, 240)).astype(np.float32) - 110
    assert evidence(image + noise) > 3 * PARAMETERS.evidence_to_track


def test_noise_alone_stays_below_the_threshold(noise_picture, rng):
    found = [
        evidence(
            noise_picture(seed, (320, 240)),
            CableState(rng.uniform(-80, 80), rng.uniform(-1, 1), rng.uniform(10, 90)),
        )
        for seed in range(50)
    ]
    assert max(found) < PARAMETERS.evidence_to_track


def test_a_flat_picture_has_no_evidence():
    assert evidence(np.full((240, 320), 127, np.uint8)) == 0.0


def test_borders_that_agree_in_sign_are_no_evidence():
    ramp = np.tile(np.linspace(0, 255, 320, dtype=np.float32), (240, 1))
    assert evidence(ramp) == 0.0


@pytest.mark.parametrize(
    "state", [CableState(1e4, 0.0, 30.0), CableState(155.0, 0.0, 40.0), CableState(0, 0, 400.0)]
)
def test_a_border_outside_the_image_is_no_evidence(draw_strip, state):
    assert evidence(draw_strip(state), state) == 0.0


def test_the_weaker_border_decides(draw_strip):
    image = draw_strip(CableState(0.0, 0.0, 50.0)).astype(np.float32)
    image[:, 160:] = 60 + (image[:, 160:] - 60) / 10
    one_sided = evidence(image, CableState(0.0, 0.0, 50.0))
    whole = evidence(draw_strip(CableState(0.0, 0.0, 50.0)), CableState(0.0, 0.0, 50.0))
    assert one_sided == pytest.approx(whole / 10, rel=0.1)


def test_the_scale_of_a_flat_picture_is_the_noise_floor():
    assert response_scale(MODEL, make_working_image(np.zeros((240, 320), np.uint8), 320)) == (
        NOISE_FLOOR
    )


def test_the_scale_follows_the_noise_and_not_the_cable(draw_strip, noise_picture):
    noise = noise_picture(1, (320, 240), 8.0).astype(np.float32)
    strip = draw_strip(TRUE).astype(np.float32) - 60
    # White noise of sigma 8 comes out of the filter with 8 times the norm of its taps.
    plain, covered = (
        response_scale(MODEL, make_working_image(image, 320)) for image in (noise, noise + strip)
    )
    assert 0.5 < plain < 3.0
    assert covered < 1.5 * plain
