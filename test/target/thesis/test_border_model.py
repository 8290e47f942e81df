import numpy as np
import pytest

from cable_tracker.target.thesis.border_model import RATE, BorderModel, transitions


def test_transitions_depend_on_the_distance():
    assert transitions(0.0)[0] == 1.0
    assert transitions(1.0) == pytest.approx((RATE * np.exp(-RATE), 1.0))


def test_at_the_border_particles_lie_along_it():
    rng = np.random.default_rng(1)
    model = BorderModel().after(np.array([158.0, 10.0]), (240, 320), True, rng)
    assert model.at_border
    placed = model.placed(np.zeros((50, 6)), (240, 320), rng)
    assert (placed[:, 0] == 160.0).all()
    assert np.abs(placed[:, 1] - 10.0).max() <= 30.0


def test_outside_they_wait_about_the_exit_farther_and_farther():
    rng = np.random.default_rng(1)
    model = BorderModel(True, 0, 158.0, 10.0)
    spreads = []
    for number in range(30):
        model = model.after(np.zeros(6), (240, 320), False, rng)
        if number in {3, 29}:
            spreads.append(np.ptp(model.placed(np.zeros((200, 6)), (240, 320), rng)[:, 1]))
    assert model.is_outside
    assert spreads[1] > 3.0 * spreads[0]


def test_in_the_middle_of_the_picture_nothing_goes_to_the_border():
    to_border, to_generic = transitions(1.0)
    assert to_border < 1e-6
    assert to_generic == 1.0
