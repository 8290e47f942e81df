import numpy as np
import pytest

from cable_tracker.target.thesis.weights import (
    alignment,
    blob_weights,
    edge_shares,
    horizon_row,
    horizon_weights,
    roberts_energy,
    sun_column,
)

IMAGE, SHAPE = np.array([0.002, 0.001, np.inf, 0.004]), np.array([4.0, 1.0, np.inf, 9.0])
CONTRAST = np.array([0.3, 0.5, 0.0, 0.2])


@pytest.mark.parametrize("form", ["eq30", "product", "likelihood_ratio"])
def test_weights_sum_to_one_and_prefer_the_better(form):
    weights = blob_weights(IMAGE, SHAPE, CONTRAST, form)
    assert weights.sum() == pytest.approx(1.0)
    assert np.argmax(weights) == 1
    assert weights[2] == 0.0


def test_equation_30_gives_the_image_about_one_nth_of_the_mass():
    count = 50
    image, shape = np.zeros(count), np.ones(count)
    image[0] = 5.0
    weights = blob_weights(image, shape, np.ones(count), "eq30")
    assert weights[0] == pytest.approx(weights[1], rel=0.03)


def test_without_any_contour_all_are_equal():
    nothing = np.full(4, np.inf)
    assert blob_weights(nothing, nothing, np.zeros(4), "product") == pytest.approx([0.25] * 4)


def test_frames_are_aligned_by_their_shift():
    before = np.random.default_rng(1).random((60, 80)).astype(np.float32)
    now = np.roll(before, (-2, 4), axis=(0, 1))
    # Rows are compared as they are: shifts in one direction at a time are exact.
    assert alignment(np.roll(before, 4, axis=1), before)[0] == 4
    assert alignment(np.roll(before, -2, axis=0), before)[1] == -2
    assert now.shape == before.shape


def test_edges_are_where_the_picture_changes():
    image = np.zeros((20, 20), np.float32)
    image[:, 10:] = 1.0
    energy = roberts_energy(image)
    assert (energy[:-1, 9] == 2.0).all()
    assert energy[:, :9].sum() == energy[:, 10:].sum() == 0.0


def test_a_horizon_is_found_where_there_is_one():
    image = np.full((40, 30), 0.8, np.float32)
    assert horizon_row(image) is None
    image[25:] = 0.2
    assert horizon_row(image) == 24


def test_what_moves_has_the_weight():
    before = np.full((60, 80), 0.8, np.float32)
    now = before.copy()
    now[20:26, 40:46] = 0.1
    weights = horizon_weights(now, before, np.ones((10, 10), bool), [(38, 18), (5, 40), (60, 5)])
    assert np.argmax(weights) == 0
    assert weights[0] > 0.9


def test_edges_near_the_sun_and_the_horizon_count_less():
    image = np.full((60, 80), 0.6, np.float32)
    image[30:] = 0.2
    image[5:12, 40:43] = 1.0
    shares = edge_shares(image)
    assert sun_column(image) == 41
    assert (shares[:, 34:49] == 0.0).all()
    assert shares[30, 5] == 0.5
    assert shares[50, 5] == shares[50, 60] == 1.0


def test_a_picture_without_sun_has_none():
    assert sun_column(np.full((60, 80), 0.6, np.float32)) is None


def test_of_a_low_picture_what_there_is_is_compared():
    picture = np.random.default_rng(1).random((5, 320)).astype(np.float32)
    assert alignment(np.roll(picture, 4, axis=1), picture)[0] == 4
    assert alignment(np.roll(picture, -1, axis=0), picture)[1] == -1
