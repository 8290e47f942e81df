import dataclasses

import numpy as np
import pytest

from cable_tracker.simulation.rendering.appearance import Bottom, Skin
from cable_tracker.simulation.rendering.seabed import (
    CABLE_REACH,
    CHANNELS,
    burial_cover,
    make_bed,
    make_cable,
)
from cable_tracker.simulation.rendering.texture import MARGIN

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


@pytest.mark.parametrize(
    ("make", "look"),
    [
        (make_bed, Bottom(gravel=1.0)),
        (make_cable, Skin(cover=1.0, turf=0.3, silt=0.2, bulge=0.1, drift=0.4)),
    ],
)
def test_the_same_draws_give_the_same_surface_and_leave_the_same_to_be_drawn(make, look):
    one, again, other = (np.random.default_rng(seed) for seed in (3, 3, 4))
    first, second, third = (make(RESOLUTION, look, rng) for rng in (one, again, other))
    for level, same in zip(first.levels, second.levels, strict=True):
        np.testing.assert_array_equal(level, same)
    assert one.bit_generator.state == again.bit_generator.state
    assert (first.levels[0] != third.levels[0]).any()


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


def _channel(skin, channel, seed=0):
    return _tile(make_cable(RESOLUTION, skin, np.random.default_rng(seed)))[..., channel]


def _at_borders(values):
    return values[:, [(CABLE_REACH - 1) * RESOLUTION, (CABLE_REACH + 1) * RESOLUTION]]


def test_turf_hides_about_the_share_of_the_borders_asked_for():
    turf = _channel(Skin(cover=0.0, turf=0.3), CHANNELS.turf)
    assert np.mean(_at_borders(turf) > 0.5) == pytest.approx(0.3, abs=0.06)


def test_silt_lies_everywhere_and_hides_nothing():
    silt = _channel(Skin(cover=0.0, silt=0.3), CHANNELS.turf)
    assert silt.mean() == pytest.approx(0.3, abs=0.05)
    assert silt.max() < 0.5


def test_crusts_push_each_border_both_ways_by_the_size_asked_for():
    outline = _at_borders(_channel(Skin(bulge=0.1), CHANNELS.outline))
    assert outline.std() == pytest.approx(0.1, rel=0.3)
    assert abs(outline.mean()) < 0.02
    assert abs(np.corrcoef(outline.T)[0, 1]) < 0.5


@pytest.mark.parametrize("seed", range(3))
def test_drifts_bury_one_border_at_a_time_over_long_stretches(seed):
    sand = _channel(Skin(cover=0.0, drift=0.5), CHANNELS.sand, seed)
    buried = _at_borders(sand) > 0
    assert not buried.all(axis=1).any()
    assert 0.2 < buried.any(axis=1).mean() < 0.7
    either = buried.any(axis=1)
    longest = max(len(run) for run in "".join("x" if each else " " for each in either).split())
    assert longest > 6 * RESOLUTION


def test_what_is_not_asked_for_leaves_the_surface_as_it_is():
    plain, coated = (
        make_cable(RESOLUTION, skin, np.random.default_rng(5)).levels[0][..., :3]
        for skin in (Skin(), Skin(turf=0.3, silt=0.2, bulge=0.1, drift=0.4))
    )
    np.testing.assert_array_equal(plain, coated)


def _across_over_along(ripple_angle):
    bottom = Bottom(ripples=3.0, stones=0.0, algae=0.0, ripple_angle=ripple_angle)
    bed = _tile(make_bed(RESOLUTION, bottom, np.random.default_rng(0)))
    across, along = (np.abs(np.diff(bed, axis=axis)).mean() for axis in (1, 0))
    return across / along


def test_ripples_run_as_asked():
    assert _across_over_along(0.0) > 1.15 * _across_over_along(90.0)
