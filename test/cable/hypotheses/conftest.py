from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.hypotheses.frame_inputs import FrameInputs, draw_frame_noise
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BorderLikelihoodRatio,
    polarity_prior,
)
from cable_tracker.cable.measure.map.cable_map import NO_MAP, NOTHING_EXPECTED
from cable_tracker.cable.parameters.parameters import TrackerParameters

NOTHING = np.empty(0)


@pytest.fixture
def frame_inputs(rng) -> Callable[[np.ndarray], FrameInputs]:
    """Return the inputs of a picture, with random numbers, without a belief before it."""
    model = BorderLikelihoodRatio(TrackerParameters())

    def make(picture: np.ndarray) -> FrameInputs:
        image = plain_image(picture.astype(np.float32))
        scan, noise = image.scan, draw_frame_noise(rng, 0, 0, 4.0)
        polarity = polarity_prior(0.5)
        return FrameInputs(
            predicted=None,
            noise=noise,
            scan=scan,
            model=model.model_for(image),
            cable_map=NO_MAP,
            expected_overlap=NOTHING_EXPECTED,
            polarity=polarity,
            reference_angle=0.0,
            ancestors=NOTHING,
            detected=NOTHING,
            anchors=NOTHING,
            counts=None,
            prior=None,
        )

    return make
