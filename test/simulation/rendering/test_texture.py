import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.simulation.rendering.texture import (
    TiledTexture,
    cloud_response,
    in_rows,
    smooth_step,
    spectral_noise,
)


def _texture(channels=None):
    shape = (64, 32) if channels is None else (64, 32, channels)
    tile = np.random.default_rng(0).random(shape, dtype=np.float32)
    return TiledTexture.from_tile(tile, 4.0), tile


def _at(texture, across, along, shift=0.0, footprint=0.01):
    p = np.array([[across]], dtype=np.float32)
    q = np.array([[along]], dtype=np.float32)
    return texture.sample(p, q, shift, np.full((1, 1), footprint, dtype=np.float32))[0, 0]


def test_a_texel_is_found_at_its_middle():
    texture, tile = _texture()
    assert _at(texture, 2.5 / 4, 7.5 / 4) == pytest.approx(tile[7, 2], abs=1e-4)


@given(st.floats(-20, 20), st.floats(-20, 20), st.integers(-3, 3), st.integers(-3, 3))
def test_repeats_in_both_directions(across, along, right, up):
    texture, _ = _texture()
    here = _at(texture, across, along)
    assert _at(texture, across + 8 * right, along + 16 * up) == pytest.approx(here, abs=2e-3)


def test_a_long_way_costs_no_precision():
    texture, _ = _texture()
    assert _at(texture, 1.3, 2.6, shift=16.0 * 10_000_000) == pytest.approx(
        _at(texture, 1.3, 2.6), abs=1e-5
    )


def test_there_is_no_seam():
    texture, _ = _texture()
    for across, along in ((8.0, 3.3), (3.3, 16.0)):
        before = _at(texture, across - 1e-4, along - 1e-4)
        assert _at(texture, across + 1e-4, along + 1e-4) == pytest.approx(before, abs=5e-3)


def test_seen_from_afar_it_shows_the_mean():
    texture, tile = _texture()
    values = [_at(texture, x, 2 * x, footprint=100.0) for x in np.linspace(0, 8, 50)]
    assert np.std(values) < 0.3 * tile.std()
    assert np.mean(values) == pytest.approx(tile.mean(), abs=0.03)


def test_channels_are_sampled_together():
    texture, tile = _texture(channels=4)
    assert _at(texture, 2.5 / 4, 7.5 / 4) == pytest.approx(tile[7, 2], abs=1e-4)


def test_noise_is_normalised_and_repeats():
    shape = (64, 128)
    noise = spectral_noise(
        cloud_response(shape, 4.0, (8.0, 8.0), 1.0), shape, np.random.default_rng(1)
    )
    assert noise.dtype == np.float32
    assert noise.mean() == pytest.approx(0.0, abs=1e-5)
    assert noise.std() == pytest.approx(1.0, abs=1e-5)
    across_the_seam = np.abs(noise[:, 0] - noise[:, -1]).max()
    assert across_the_seam < 3 * np.abs(np.diff(noise, axis=1)).max()


def test_smooth_step_is_flat_outside_and_half_in_the_middle():
    assert smooth_step(np.array([-1.0, 2.0, 3.0, 4.0, 9.0]), 2.0, 4.0).tolist() == [0, 0, 0.5, 1, 1]


def test_indices_are_gathered_into_rows_and_the_last_is_repeated():
    assert in_rows(np.array([2, 3, 5, 7]), 3).tolist() == [[2, 3, 5], [7, 7, 7]]
    assert in_rows(np.array([2, 3, 5]), 3).tolist() == [[2, 3, 5]]
