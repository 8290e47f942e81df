"""The compiled filter as a whole against the one in NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.compiled_bootstrap_filter import CompiledBootstrapFilter
from cable_tracker.cable.measure.response_table import load_table
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.bootstrap_filter import NumpyBootstrapFilter, make_observation
from cable_tracker.particle_filter.particles import Particles

TABLE = load_table("")
SIGMA = np.array([3.0, 0.04, 3.0, 0.02, 5.0, 0.05, 0.0, 0.0])
SAMPLINGS = pytest.mark.parametrize("sampling", ["scan_lines", "taps"])


def cloud(state: CableState, count: int, seed: int = 0, scale: float = 1.0) -> Particles:
    sigma = SIGMA * np.array([scale, 1, scale, 1, scale, 1, scale, 1])
    noise = np.random.default_rng(seed).standard_normal((count, 8))
    return Particles.equally_weighted(state.to_array() + noise * sigma)


def both(particles, width=320, **changes):
    parameters = preset("thesis").replaced({"particle_count": particles.count, **changes})
    observation = make_observation(parameters, TABLE)
    return (
        CompiledBootstrapFilter(particles, parameters, width, np.random.default_rng(1)),
        NumpyBootstrapFilter(
            particles, parameters, observation, width, np.random.default_rng(1)
        ),
    )  # fmt: skip


def assert_same_sight(found, expected, rtol=1e-4):
    scale = np.sqrt(np.diag(expected.covariance)) + 1e-6
    np.testing.assert_allclose((found.mean - expected.mean) / scale, 0.0, atol=rtol)
    difference = (found.covariance - expected.covariance) / np.outer(scale, scale)
    np.testing.assert_allclose(difference, 0.0, atol=rtol)
    assert found.evidence == pytest.approx(expected.evidence, rel=1e-3, abs=1e-3)
    assert found.effective_sample_size == pytest.approx(expected.effective_sample_size, rel=rtol)


def looked(filters, picture, parameters_width=320):
    image = make_working_image(picture, parameters_width)
    return [each.look(image) for each in filters]


@SAMPLINGS
@settings(max_examples=25)
@given(
    angle=st.floats(-1.57, 1.57),
    distance=st.floats(-120.0, 120.0),
    seed=st.integers(0, 2**31),
)
def test_one_frame_weighs_as_in_numpy(sampling, angle, distance, seed):
    picture = np.random.default_rng(seed).normal(110.0, 20.0, (120, 160)).astype(np.float32)
    particles = cloud(CableState(distance, angle, 30.0, 0.02), 100, seed)
    filters = both(particles, width=160, response_sampling=sampling, limit_handling="reflect")
    compiled, plain = filters
    compiled.look(make_working_image(picture, 320))
    plain.look(make_working_image(picture, 320))
    # A border that just opposes the other, or not, may do so by rounding.
    ratio = compiled.particles.weights / plain.particles.weights
    assert np.median(np.abs(ratio - 1.0)) < 1e-3
    assert (np.abs(ratio / np.median(ratio) - 1.0) < 2e-3).mean() > 0.95


@SAMPLINGS
@pytest.mark.parametrize("scheme", ["multinomial", "stratified", "systematic", "residual"])
def test_a_short_sequence_is_tracked_as_in_numpy(draw_strip, noise_picture, sampling, scheme):
    state = CableState(10.0, 0.15, 40.0, 0.02)
    filters = both(cloud(state, 200), response_sampling=sampling, resampling=scheme)
    for number in range(6):
        strip = draw_strip(CableState(10.0 + number, 0.15, 40.0, 0.02)).astype(np.float32)
        picture = np.clip(strip + noise_picture(number, (320, 240)) - 110.0, 0, 255)
        if number:
            for each in filters:
                each.predict(0.04)
        assert_same_sight(*looked(filters, picture.astype(np.uint8)))


@SAMPLINGS
@pytest.mark.parametrize("size", [(320, 240), (500, 333), (640, 480), (960, 540)])
@pytest.mark.parametrize("angle", [0.1, 0.8, 1.5])
def test_frames_of_any_size_are_seen_as_in_numpy(draw_strip, sampling, size, angle):
    scale = size[0] / 320
    state = CableState(10.0 * scale, angle, 40.0 * scale, 0.02)
    filters = both(cloud(state, 80, scale=scale), width=size[0], response_sampling=sampling)
    assert_same_sight(*looked(filters, draw_strip(state, size, blur=2 * scale)))


@SAMPLINGS
def test_frames_of_any_kind_are_read(draw_strip, sampling):
    state = CableState(10.0, 0.3, 40.0, 0.02)
    picture = draw_strip(state)
    gaps = np.zeros((240, 640), np.uint8)[:, ::2]
    gaps[:] = picture
    locked = picture.copy()
    locked.setflags(write=False)
    sights = [
        looked(both(cloud(state, 50), response_sampling=sampling)[:1], frame)[0]
        for frame in (picture, gaps, locked, picture.astype(np.float32), np.asfortranarray(picture))
    ]
    for sight in sights[1:]:
        assert_same_sight(sight, sights[0], rtol=1e-6)


@pytest.mark.parametrize("angle", [0.05, 1.5])
def test_many_particles_are_looked_up_as_in_numpy(draw_strip, angle):
    state = CableState(10.0, angle, 40.0, 0.02)
    filters = both(cloud(state, 20_000), limit_handling="reflect")
    assert_same_sight(*looked(filters, draw_strip(state, blur=2.0)), rtol=1e-3)


def test_particles_that_search_are_weighed_as_in_numpy(draw_strip):
    rng = np.random.default_rng(0)
    states = rng.uniform(
        [-150, -1.5, 10, 0, 0, 0, 0, 0], [150, 1.5, 90, 0.1, 1, 1, 0, 0], (3000, 8)
    )
    filters = both(Particles.equally_weighted(states))
    looked(filters, draw_strip(CableState(10.0, 0.3, 40.0, 0.02), blur=2.0))
    compiled, plain = (each.particles.weights for each in filters)
    assert (np.abs(compiled / plain - 1.0) < 1e-2).mean() > 0.99


@SAMPLINGS
def test_the_same_seed_gives_the_same_bit_for_bit(draw_strip, sampling):
    state = CableState(10.0, 0.3, 40.0, 0.02)
    picture = draw_strip(state)
    results = []
    for _ in range(2):
        compiled, _ = both(cloud(state, 100), response_sampling=sampling)
        for _ in range(5):
            sight = compiled.look(make_working_image(picture, 320))
            compiled.predict(0.04)
        results.append(sight)
    np.testing.assert_array_equal(results[0].mean, results[1].mean)
    np.testing.assert_array_equal(results[0].covariance, results[1].covariance)


def test_another_number_of_particles_is_drawn_from_the_present_ones():
    compiled, _ = both(cloud(CableState(10.0, 0.3, 40.0), 50))
    before = compiled.particles.states
    compiled.resample(120)
    after = compiled.particles
    assert after.count == 120
    assert set(after.states[:, 0]) <= set(before[:, 0])
    compiled.predict(0.04)
    assert np.isfinite(compiled.particles.states).all()
