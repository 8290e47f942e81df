from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.line_pair_proposer import LinePairProposer

pytest.importorskip("numba")

from cable_tracker.detection.compiled.line_pair_proposer import CompiledLinePairProposer

SIZES = [(160, 120), (16, 16), (16, 200), (300, 16), (500, 400), (4000, 16)]


def assert_alike(picture) -> np.ndarray:
    image = make_working_image(picture, 320)
    expected = LinePairProposer().propose(image)
    found = CompiledLinePairProposer().propose(image)
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)
    return found


@pytest.mark.parametrize("size", [(160, 120), (500, 400)])
@pytest.mark.parametrize("seed", range(30))
def test_in_noise_the_same_cables_are_proposed(seed, size):
    # Not in any: now and then two lines have equal votes, and rounding says which is first.
    rng = np.random.default_rng(seed)
    assert_alike(rng.normal(100, 20, size[::-1]).astype(np.float32))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(5))
def test_in_pictures_of_any_shape_the_same_cables_are_proposed(seed, size):
    rng = np.random.default_rng(seed)
    assert_alike(rng.normal(100, 20, size[::-1]).astype(np.float32))


@settings(max_examples=40)
@given(st.floats(-60, 60), st.floats(-2, 2), st.floats(12, 60), st.floats(-0.1, 0.1))
def test_of_any_strip_the_same_cables_are_proposed(draw_strip_of, distance, angle, width, skew):
    picture = draw_strip_of(CableState(distance, angle, width, skew))
    assert_alike(picture)


@pytest.fixture(scope="module")
def draw_strip_of():
    x = (np.arange(160) - 79.5)[None, :]
    y = (59.5 - np.arange(120))[:, None]
    noise = np.random.default_rng(1).normal(0, 3, (120, 160))

    def draw(cable) -> np.ndarray:
        across = x * np.cos(cable.angle) + y * np.sin(cable.angle) - cable.distance
        inside = np.tanh(cable.width / 2 - np.abs(across))
        return (100 + 40 * inside + noise).astype(np.float32)

    return draw


@pytest.mark.parametrize("angle", [np.pi / 2, -np.pi / 2 + 0.01, np.pi / 2 - 0.01])
def test_across_the_wrap_the_cable_is_found_by_both(draw_strip_of, angle):
    truth = CableState(10.0, angle, 30.0)
    found = assert_alike(draw_strip_of(truth))
    states = np.zeros((len(found), 8))
    states[:, :4] = found
    chart = unwrap_states(states, angle)
    assert np.abs(chart[:, 0] - 10.0).min() < 4.0
    assert ((found[:, 1] > -np.pi / 2) & (found[:, 1] <= np.pi / 2)).all()


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("value", [0, 255])
def test_in_a_flat_picture_nothing_is_proposed(size, value):
    assert assert_alike(np.full(size[::-1], value, np.uint8)).shape == (0, 4)


def test_a_single_edge_is_no_cable():
    picture = np.where(np.arange(160) < 60, 0, 255) * np.ones((120, 1))
    assert len(assert_alike(picture.astype(np.uint8))) == 0
