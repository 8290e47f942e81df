import numpy as np
import pytest

from cable_tracker.contour.shape_energy import histogram_energy, level_set_energy, shape_energy
from cable_tracker.errors import FrameError


def test_the_same_shape_has_no_energy(draw_disc):
    disc = draw_disc(50, 50, (25, 25), 10)
    assert shape_energy(disc, disc, 1.0, 1.0) == 0.0


def test_discs_of_other_radius_are_as_far_apart_as_their_radii(draw_disc):
    small, large = (draw_disc(80, 80, (40, 40), radius) for radius in (15, 20))
    assert level_set_energy(small, large) == pytest.approx(25.0, rel=0.15)
    assert level_set_energy(small, large) == level_set_energy(large, small)


def test_histograms_without_a_partner_count_in_full():
    one, two = np.eye(8)[:1], np.eye(8)[:2]
    assert histogram_energy(one, one) == 0.0
    assert histogram_energy(one, two) == histogram_energy(two, one) == 1.0


def test_both_energies_are_weighted(draw_disc):
    disc, square = draw_disc(50, 50, (25, 25), 10), np.zeros((50, 50), bool)
    square[15:36, 15:36] = True
    levels, both = shape_energy(disc, square, 1.0, 0.0), shape_energy(disc, square, 2.0, 3.0)
    assert both > 2.0 * levels > 0.0


def test_what_cannot_be_compared_is_refused(draw_disc):
    disc = draw_disc(50, 50, (25, 25), 10)
    with pytest.raises(FrameError, match="compared"):
        level_set_energy(disc, disc[1:])
    with pytest.raises(FrameError, match="empty"):
        level_set_energy(disc, np.zeros_like(disc))
