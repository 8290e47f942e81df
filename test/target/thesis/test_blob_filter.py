import numpy as np
import pytest

from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.presets import target_preset
from cable_tracker.target.tracker import TargetTracker

STEP = 40_000_000


def box_of(mask):
    rows, columns = np.nonzero(mask)
    return columns.min(), rows.min(), columns.max() + 1, rows.max() + 1


@pytest.mark.parametrize("weights", ["product", "likelihood_ratio"])
def test_a_dark_target_that_stands_is_kept(draw, weights):
    tracker = TargetTracker(target_preset("thesis").replaced({"blob_weights": weights}))
    _, mask = draw(colour=(5, 5, 5))
    tracker.initialise(TargetStart.from_box(*box_of(mask)))
    for number in range(1, 8):
        estimate = tracker.process(draw(colour=(5, 5, 5), seed=number)[0], number * STEP)
    assert estimate.status.value == "TRACKING"
    assert np.hypot(*estimate.state[:2]) < 8.0
    assert estimate.scale == pytest.approx(1.0, abs=0.25)


def test_the_product_follows_a_slow_target(draw):
    parameters = target_preset("thesis").replaced({"blob_weights": "product", "seed": 2})
    tracker = TargetTracker(parameters)
    for number in range(1, 15):
        image, mask = draw(centre=(120 + 2 * number, 120), colour=(5, 5, 5), seed=number)
        if number == 1:
            tracker.initialise(TargetStart.from_box(*box_of(mask)))
        estimate = tracker.process(image, number * STEP)
    assert estimate.state[0] == pytest.approx(148 - 159.5, abs=8.0)


@pytest.mark.parametrize("model", ["near_horizon", "boundary"])
def test_the_other_models_keep_a_target_in_the_middle(draw, model):
    tracker = TargetTracker(target_preset("thesis").replaced({"blob_model": model}))
    _, mask = draw(colour=(5, 5, 5))
    tracker.initialise(TargetStart.from_box(*box_of(mask)))
    for number in range(1, 6):
        estimate = tracker.process(draw(colour=(5, 5, 5), seed=number)[0], number * STEP)
    assert np.isfinite(estimate.state).all()
    assert np.hypot(*estimate.state[:2]) < 25.0


def test_what_has_no_contrast_is_refused(draw):
    tracker = TargetTracker(target_preset("thesis"))
    tracker.initialise(TargetStart.from_box(100, 80, 150, 120))
    assert "stand out" in tracker.process(draw(centre=None)[0], STEP).event
