import numpy as np
import pytest

from cable_tracker.simulation.seabed import CABLE_REACH, CHANNELS, make_bed, make_cable
from cable_tracker.simulation.texture import MARGIN

RESOLUTION = 8


def _tile(texture):
    return texture.levels[0][MARGIN:-MARGIN, MARGIN:-MARGIN]


def _hidden(clutter, seed=0):
    tile = _tile(make_cable(RESOLUTION, clutter, np.random.default_rng(seed)))
    cover = np.maximum(tile[..., CHANNELS.growth], tile[..., CHANNELS.burial])
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
    for texture in (
        make_bed(RESOLUTION, np.random.default_rng(0)),
        make_cable(RESOLUTION, 1.0, np.random.default_rng(0)),
    ):
        assert texture.levels[0].min() >= 0.0
        assert texture.levels[0].max() <= 1.0


def test_the_bottom_has_texture():
    bed = _tile(make_bed(RESOLUTION, np.random.default_rng(0)))
    assert 0.2 < bed.mean() < 0.4
    assert bed.std() > 0.04
