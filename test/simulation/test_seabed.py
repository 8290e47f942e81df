import dataclasses

import numpy as np
import pytest

from cable_tracker.simulation.look import Bottom, Skin
from cable_tracker.simulation.seabed import (
    CABLE_REACH,
    CHANNELS,
    burial_cover,
    make_bed,
    make_cable,
)
from cable_tracker.simulation.texture import MARGIN

RESOLUTION = 8


def _tile(texture):
    return texture.levels[0][MARGIN:-MARGIN, MARGIN:-MARGIN]


def _hidden(clutter, seed=0):
    tile = _tile(make_cable(RESOLUTION, Skin(cover=clutter), np.random.default_rng(seed)))
    cover = np.maximum(tile[..., CHANNELS.growth], burial_cover(tile[..., CHANNELS.sand]))
    return cover, cover[:, [(CABLE_REACH - 1) * RESOLUTION, (CABLE_REACH + 1) * RESOLUTION]]


def test_a_clean_cable_is_free_everywhere():
    cover, _ = _hidden(0.0)
    assert cover.max() == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_half_clutter_leaves_seven_to_nine_tenths_of_the_borders_visible(seed):
    _, borders = _hidden(0.5, seed)
    assert 0.7 < np.mean(borders < 0.5) < 0.9


def test_more_clutter_hides_more():
    shares = [np.mean(_hidden(clutter)[1] > 0.5) for clutter in (0.2, 0.5, 1.0)]
    assert shares == sorted(shares)
    assert shares[-1] > 0.3


def test_growth_is_not_cut_off_at_the_rim_of_its_texture():
    cover, _ = _hidden(1.0)
    assert cover[:, [0, -1]].max() < 0.05


def test_everything_is_a_share_of_light():
    bed = _tile(make_bed(RESOLUTION, Bottom(gravel=1.0), np.random.default_rng(0)))
    cable = _tile(make_cable(RESOLUTION, Skin(cover=1.0), np.random.default_rng(0)))
    for values in (bed, np.delete(cable, CHANNELS.sand, axis=-1)):
        assert values.min() >= 0.0
        assert values.max() <= 1.0


def test_the_bottom_has_texture():
    bed = _tile(make_bed(RESOLUTION, Bottom(), np.random.default_rng(0)))
    assert 0.2 < bed.mean() < 0.4
    assert bed.std() > 0.04


@pytest.mark.parametrize("part", ["ripples", "stones", "algae", "gravel"])
def test_every_part_of_the_bottom_adds_texture(part):
    bare = Bottom(ripples=0.0, stones=0.0, algae=0.0)
    with_part = dataclasses.replace(bare, **{part: 1.0})
    plain, textured = (
        _tile(make_bed(RESOLUTION, bottom, np.random.default_rng(0)))
        for bottom in (bare, with_part)
    )
    assert (textured - plain).std() > 0.005


def test_gravel_repeats_without_a_seam():
    bed = _tile(make_bed(RESOLUTION, Bottom(gravel=1.0, stones=0.0), np.random.default_rng(1)))
    inside = np.abs(np.diff(bed, axis=1)).mean(axis=0)
    assert np.abs(bed[:, 0] - bed[:, -1]).mean() < inside.max() * 1.2
