import numpy as np
import pytest

from cable_tracker.target.measure.working_frame import make_working_frame
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.presets import target_preset
from cable_tracker.target.thesis.blob_filter import BlobFilter
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.tracking.image_frame import bounding_box

STEP = 40_000_000


@pytest.mark.parametrize("weights", ["product", "likelihood_ratio"])
def test_a_dark_target_that_stands_is_kept(draw, weights):
    tracker = TargetTracker(target_preset("thesis").replaced({"blob_weights": weights}))
    _, mask = draw(colour=(5, 5, 5))
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
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
            tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
        estimate = tracker.process(image, number * STEP)
    assert estimate.state[0] == pytest.approx(148 - 159.5, abs=8.0)


@pytest.mark.parametrize("model", ["near_horizon", "boundary"])
def test_the_other_models_keep_a_target_in_the_middle(draw, model):
    tracker = TargetTracker(target_preset("thesis").replaced({"blob_model": model}))
    _, mask = draw(colour=(5, 5, 5))
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    for number in range(1, 6):
        estimate = tracker.process(draw(colour=(5, 5, 5), seed=number)[0], number * STEP)
    assert np.isfinite(estimate.state).all()
    assert np.hypot(*estimate.state[:2]) < 25.0


def test_what_has_no_contrast_is_refused(draw):
    tracker = TargetTracker(target_preset("thesis"))
    tracker.initialise(TargetStart.from_box(100, 80, 150, 120))
    assert "stand out" in tracker.process(draw(centre=None)[0], STEP).event


def test_a_mark_that_fills_the_picture_is_refused():
    picture = np.full((48, 64), 90, np.uint8)
    tracker = TargetTracker(target_preset("thesis"))
    corners = [[0.2, 0.2], [63.8, 0.2], [63.8, 47.8], [0.2, 47.8]]
    tracker.initialise(TargetStart(np.array(corners)))
    assert "fills the picture" in tracker.process(picture, STEP).event


def test_a_mark_that_leaves_nothing_around_it_is_refused():
    picture = np.full((48, 64), 90, np.uint8)
    picture[44:, :4] = 0
    tracker = TargetTracker(target_preset("thesis"))
    corners = [[0.2, 0.2], [63.8, 0.2], [63.8, 47.8], [3.2, 47.8], [0.2, 44.8]]
    tracker.initialise(TargetStart(np.array(corners)))
    assert "around it" in tracker.process(picture, STEP).event


def test_the_number_of_particles_changes_on_the_way(draw):
    tracker = TargetTracker(target_preset("thesis"))
    _, mask = draw(colour=(5, 5, 5))
    tracker.initialise(TargetStart.from_box(*bounding_box(mask)))
    tracker.process(draw(colour=(5, 5, 5))[0], STEP)
    tracker.configure(tracker.parameters.replaced({"particle_count": 33}))
    tracker.process(draw(colour=(5, 5, 5), seed=2)[0], 2 * STEP)
    assert tracker.particles.count == 33


@pytest.mark.parametrize("zoom", [1, 2])
def test_how_near_a_shape_is_does_not_depend_on_the_working_width(draw, zoom):
    size, centre = (320 * zoom, 240 * zoom), (160 * zoom, 120 * zoom)
    image, _ = draw(centre, (22 * zoom, 14 * zoom), size, colour=(5, 5, 5))
    _, larger = draw(centre, (26 * zoom, 18 * zoom), size)
    parameters = target_preset("thesis").replaced({"blob_iterations": 60})
    blobs = BlobFilter(parameters, np.random.default_rng(0))
    summary, _ = blobs.start(make_working_frame(image, size[0]), larger, is_exact=True)
    assert summary.outline.area == pytest.approx(np.pi * 22 * 14 * zoom**2, rel=0.1)
    assert summary.is_whole
