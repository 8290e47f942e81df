import numpy as np
import pytest

from cable_tracker.target.measure.appearance import (
    bins_of,
    choose_bins,
    learn_appearance,
    looked_up,
)
from cable_tracker.target.measure.working_frame import channels_of


def learnt(image, mask, is_coloured=True):
    channels = channels_of(image)
    bins = choose_bins(channels, is_coloured)
    bin_map = bins_of(channels, bins.lookups)
    return learn_appearance(bin_map, mask, bins), bin_map


def test_pixels_of_the_target_are_likelier_target(draw):
    image, mask = draw()
    appearance, bin_map = learnt(image, mask)
    ratios = looked_up(bin_map, appearance.log_ratios(2.5))
    assert ratios[mask].mean() > 1.5
    assert ratios[~mask].mean() < -1.5


def test_pixels_of_the_target_are_likelier_target_in_grey(draw):
    image, mask = draw(colour=(10, 10, 10))
    appearance, bin_map = learnt(image[..., 1].copy(), mask, is_coloured=False)
    ratios = looked_up(bin_map, appearance.log_ratios(2.5))
    assert ratios[mask].mean() > ratios[~mask].mean() + 2.0


def test_colours_that_neither_has_are_not_the_targets(draw):
    appearance, _ = learnt(*draw())
    unseen = (appearance.target == 0.0) & (appearance.surroundings == 0.0)
    assert np.median(appearance.log_ratios(2.5)[unseen]) < 0.0


def test_likeness_is_one_to_itself_and_less_to_others(draw):
    appearance, _ = learnt(*draw())
    assert appearance.likeness(appearance.target) == pytest.approx(1.0)
    assert appearance.likeness(appearance.surroundings) < 0.3


def test_it_moves_towards_what_is_seen(draw):
    appearance, _ = learnt(*draw())
    moved = appearance.adapted(appearance.surroundings, appearance.surroundings, 0.5, 0.0)
    assert moved.target == pytest.approx((appearance.target + appearance.surroundings) / 2)
    np.testing.assert_array_equal(moved.surroundings, appearance.surroundings)
