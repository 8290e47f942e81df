from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.kalman import CableKalmanFilter, KalmanNoise

NOTHING = (0.0, 0.0, 0.0, 0.0)
UNIT = (1.0, 1.0, 1.0, 1.0)
DEGREE = np.pi / 180


def noise(measurement=UNIT, diffusion=NOTHING, rate=NOTHING, initial=NOTHING) -> KalmanNoise:
    return KalmanNoise(measurement, diffusion, rate, initial)


def start(state: CableState, width=320, **kinds) -> CableKalmanFilter:
    return CableKalmanFilter.start(state, noise(**kinds), width)


def test_the_start_is_the_measurement_with_its_noise():
    belief = start(CableState(5.0, 0.1, 30.0, 0.02, 99.0, 9.0), initial=(2, 1, 0, 0))
    np.testing.assert_allclose(belief.mean, [5.0, 0.1, 30.0, 0.02, 0, 0, 0, 0])
    # A rate per frame at 25 frames per second is 25 times as large per second.
    expected = [1, DEGREE**2, 1, DEGREE**2, 50.0**2, (25 * DEGREE) ** 2, 0, 0]
    np.testing.assert_allclose(belief.covariance, np.diag(expected))


def test_two_equal_measurements_halve_the_variance():
    belief = start(CableState(10.0, 0.0, 30.0)).updated(CableState(14.0, 0.0, 30.0))
    assert belief.state.distance == pytest.approx(12.0)
    assert belief.covariance[0, 0] == pytest.approx(0.5)


def test_a_prediction_and_an_update_by_hand():
    # d: variance 1, rate variance 25^2 = 625 per s^2; after 0.04 s the variance is 1 + 625 * 0.0016
    # = 2, and the covariance with the rate is 625 * 0.04 = 25.
    belief = start(CableState(10.0, 0.0, 30.0), initial=(1, 0, 0, 0)).predicted(0.04)
    assert belief.covariance[0, 0] == pytest.approx(2.0)
    assert belief.covariance[0, 4] == pytest.approx(25.0)
    # Gain 2 / 3 on d and 25 / 3 per s on its rate; the innovation is 3 px.
    updated = belief.updated(CableState(13.0, 0.0, 30.0))
    assert updated.mean[0] == pytest.approx(12.0)
    assert updated.mean[4] == pytest.approx(25.0)
    assert updated.covariance[0, 0] == pytest.approx(2 / 3)
    assert updated.covariance[4, 4] == pytest.approx(625 - 25 * 25 / 3)


def test_process_noise_by_hand():
    belief = start(CableState(0.0, 0.0, 30.0), diffusion=(2, 0, 0, 0), rate=(1, 0, 0, 0)).predicted(
        0.08
    )
    # Two frames: 2 * 2^2 by itself; the rate's q = 25^3 per s: q t^3 / 3, q t^2 / 2, q t.
    q = 25.0**3
    assert belief.covariance[0, 0] == pytest.approx(1 + 8 + q * 0.08**3 / 3)
    assert belief.covariance[0, 4] == pytest.approx(q * 0.08**2 / 2)
    assert belief.covariance[4, 4] == pytest.approx(q * 0.08)


def test_two_short_predictions_are_one_long_one():
    belief = start(
        CableState(1.0, 0.2, 30.0, 0.01),
        diffusion=(1, 0.3, 1, 0.2),
        rate=(0.5, 0.1, 0.2, 0.1),
        initial=UNIT,
    ).updated(CableState(3.0, 0.25, 28.0, 0.02))
    once, twice = belief.predicted(0.1), belief.predicted(0.03).predicted(0.07)
    np.testing.assert_allclose(once.mean, twice.mean)
    np.testing.assert_allclose(once.covariance, twice.covariance)


def test_a_steady_motion_is_learnt_whatever_the_intervals():
    rng = np.random.default_rng(7)
    belief = start(CableState(0.0, 0.0, 30.0), initial=(5, 1, 1, 1))
    time = 0.0
    for dt in rng.uniform(0.02, 0.08, 60):
        time += dt
        belief = belief.predicted(dt).updated(CableState(40.0 * time, 0.3 * time, 30.0))
    assert belief.state.distance_rate == pytest.approx(40.0, rel=0.01)
    assert belief.state.angle_rate == pytest.approx(0.3, rel=0.01)


def test_a_measurement_across_the_wrap_is_near():
    belief = start(CableState(30.0, 89 * DEGREE, 40.0, 0.05))
    across = CableState(-31.0, -89.5 * DEGREE, 40.0, -0.05)
    # 1 px and 1.5 deg away, each variance 2.
    assert belief.squared_distance(across) == pytest.approx((1.0 + 1.5**2) / 2)
    updated = belief.updated(across).state
    assert updated.distance == pytest.approx(30.5)
    assert updated.angle == pytest.approx(89.75 * DEGREE)
    assert updated.skew == pytest.approx(0.05)


def test_the_belief_turns_its_signs_when_it_crosses_the_wrap():
    belief = start(CableState(30.0, 89.9 * DEGREE, 40.0, 0.05), initial=UNIT)
    mean = np.array([30.0, 89.9 * DEGREE, 40.0, 0.05, 10.0, 10 * DEGREE, 2.0, 0.01])
    turning = CableKalmanFilter(mean, belief.covariance, belief.noise, 320)
    after = turning.predicted(0.04)
    expected = [-30.4, -89.7 * DEGREE, 40.08, -0.0504, -10.0, 10 * DEGREE, 2.0, -0.01]
    np.testing.assert_allclose(after.mean, expected)
    # d and alpha were not correlated with the rates of others; d and its own rate turn together.
    assert after.covariance[0, 4] > 0
    np.testing.assert_allclose(np.diag(after.covariance) > 0, True)


def test_the_covariance_of_components_that_turn_apart_changes_its_sign():
    covariance = np.diag(np.full(8, 4.0))
    covariance[0, 2] = covariance[2, 0] = 1.0
    mean = np.array([30.0, 89.9 * DEGREE, 40.0, 0.0, 0.0, 10 * DEGREE, 0.0, 0.0])
    after = CableKalmanFilter(mean, covariance, noise(), 320).predicted(0.04)
    assert after.covariance[0, 2] == pytest.approx(-1.0)


def test_lengths_of_the_noise_scale_with_the_image_and_angles_do_not():
    wide = start(CableState(0.0, 0.0, 30.0), width=640)
    np.testing.assert_allclose(np.diag(wide.covariance)[:4], [4.0, DEGREE**2, 4.0, DEGREE**2])


@given(
    st.lists(
        st.tuples(
            st.floats(-100, 100), st.floats(-1.57, 1.57), st.floats(5, 100), st.floats(-0.2, 0.2)
        ),
        min_size=1,
        max_size=15,
    )
)
def test_the_covariance_stays_symmetric_and_positive(measurements):
    belief = CableKalmanFilter.start(CableState(0.0, 0.0, 30.0), KalmanNoise(UNIT), 320)
    for values in measurements:
        belief = belief.predicted(0.04).updated(CableState(*values))
    np.testing.assert_allclose(belief.covariance, belief.covariance.T, rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(belief.covariance).min() > 0
    assert -np.pi / 2 <= belief.state.angle <= np.pi / 2
    assert belief.state.to_array() == pytest.approx(belief.mean)
