from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

pytest.importorskip("numba")

from cable_tracker.cable.compiled.likelihood_ratio import (
    CompiledLikelihoodRatio,
    RatioArrays,
    measure_into,
)

STRIP = CableState(12.0, 0.2, 24.0, 0.03)
PLAIN = BorderLikelihoodRatio(TrackerParameters())
COMPILED = CompiledLikelihoodRatio(TrackerParameters())

ONE_BIN = 0.25
"""Rounding may put a measure into the next bin of a table, seldom: that changes a ratio so much."""


def any_cables(rng, count, size) -> np.ndarray:
    """Cables of all kinds, also outside the picture, also written with angles beyond the wrap."""
    states = rng.uniform(-1, 1, (count, 8)) * np.array([1.2 * size[0], 6, 0, 0.3, 1, 1, 1, 1])
    states[:, 2] = rng.uniform(1, size[0], count)
    return states


def assert_alike(states, image) -> None:
    expected, found = PLAIN.measure(states, image), COMPILED.measure(states, image)
    np.testing.assert_allclose(found.seen, expected.seen, rtol=1e-9)
    for one, other in (
        (found.log_ratios, expected.log_ratios),
        (found.weaker_borders, expected.weaker_borders),
    ):
        assert one.shape == other.shape
        differences = np.abs(one - other)
        assert (differences < ONE_BIN).all()
        assert (differences < 1e-4).mean() > 0.9


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.sampled_from([(160, 120), (33, 57), (400, 300), (16, 16)]))
def test_any_cable_in_any_picture_is_measured_alike(seed, size):
    rng = np.random.default_rng(seed)
    picture = rng.uniform(0, 255, size[::-1]).astype(np.float32)
    image = make_working_image(picture, 320, sample_spacing=float(rng.uniform(2, 40)))
    assert_alike(any_cables(rng, 40, size), image)


def test_cables_near_the_true_one_are_measured_alike(draw_strip, noise_picture, rng):
    picture = draw_strip(STRIP, (160, 120)) + noise_picture(1).astype(np.float32) - 110.0
    states = STRIP.to_array() + rng.standard_normal((500, 8)) * [3, 0.05, 3, 0.05, 1, 1, 1, 1]
    assert_alike(states, make_working_image(picture.astype(np.float32), 320))


@pytest.mark.parametrize("value", [0, 90, 255])
def test_in_a_flat_picture_both_say_about_the_same(value, rng):
    # Nothing at all lies between two bins of the table.
    image = make_working_image(np.full((120, 160), value, np.uint8), 320)
    states = any_cables(rng, 60, (100, 75))
    expected, found = PLAIN.measure(states, image), COMPILED.measure(states, image)
    np.testing.assert_allclose(found.log_ratios, expected.log_ratios, rtol=0.1)


@pytest.mark.parametrize("size", [(4000, 16), (16, 4000)])
def test_a_picture_one_pixel_high_is_measured_alike(size, rng):
    picture = rng.uniform(0, 255, size[::-1]).astype(np.float32)
    states = any_cables(rng, 60, size)
    # These borders run along the only row.
    states[:3, :4] = [[0.0, np.pi / 2, 1e-9, 0.0], [0.0, -np.pi / 2, 0.0, 0.0], [0, 1.57, 0, 0]]
    assert_alike(states, make_working_image(picture, 320))


def test_no_cable_is_measured_as_none(rng):
    image = make_working_image(rng.uniform(0, 255, (60, 80)).astype(np.float32), 320)
    evidence = COMPILED.measure(np.empty((0, 8)), image)
    assert evidence.log_ratios.shape == (0, 2)
    assert evidence.seen.shape == (0,)


def test_what_is_no_number_is_outside(rng):
    image = make_working_image(rng.uniform(0, 255, (60, 80)).astype(np.float32), 320)
    evidence = COMPILED.measure(np.array([[np.nan, 0.1, 30.0, 0.0]]), image)
    assert evidence.seen[0] == 0.0
    assert evidence.log_ratios.max() < 0.0


def test_only_the_rows_asked_for_are_filled_in(rng):
    image = make_working_image(rng.uniform(0, 255, (60, 80)).astype(np.float32), 320)
    states = any_cables(rng, 10, (80, 60))
    results = RatioArrays(np.full((10, 2), 7.0), np.full((10, 2), 7.0), np.full(10, 7.0))
    measure_into(states, 3, 6, COMPILED.look(image), results)
    whole = COMPILED.measure(states, image)
    for column, expected in zip(
        results, (whole.log_ratios, whole.weaker_borders, whole.seen), strict=True
    ):
        np.testing.assert_array_equal(column[3:6], expected[3:6])
        assert (column[:3] == 7.0).all()
        assert (column[6:] == 7.0).all()
