from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.model.statistics import cable_mean_and_covariance, mean_line_angle

DEGREE = np.pi / 180


def cloud(rng, angle: float, count: int = 200) -> np.ndarray:
    """Cables around one direction, all written with angles near it."""
    sigma = np.array([3.0, 4 * DEGREE, 2.0, DEGREE, 5.0, 0.05, 3.0, 0.02])
    mean = np.array([20.0, angle, 30.0, 2 * DEGREE, 4.0, 0.1, 1.0, 0.03])
    return mean + rng.standard_normal((count, 8)) * sigma


def rewritten(states: np.ndarray, which: np.ndarray, half_turn: float = np.pi) -> np.ndarray:
    """Write some of the cables with their normals turned round."""
    result = states.copy()
    result[which, 1] += half_turn
    for column in (0, 3, 4, 7):
        result[which, column] *= -1
    return result


def test_lines_on_both_sides_of_the_wrap_average_across_it():
    states = np.array(
        [
            [10.0, 89 * DEGREE, 30.0, 0.1, 5.0, 0.2, 1.0, 0.04],
            [-12.0, -89 * DEGREE, 34.0, -0.1, -7.0, 0.4, 3.0, -0.02],
        ]
    )
    mean, covariance = cable_mean_and_covariance(states, np.array([0.5, 0.5]))
    expected = [11.0, 90 * DEGREE, 32.0, 0.1, 6.0, 0.3, 2.0, 0.03]
    np.testing.assert_allclose(mean, expected, atol=1e-12)
    np.testing.assert_allclose(np.diag(covariance)[:3], [1.0, DEGREE**2, 4.0], atol=1e-12)


def test_lines_on_one_side_average_like_numbers():
    states = np.array([[1.0, 0.1, 20.0, *[0.0] * 5], [3.0, 0.3, 22.0, *[0.0] * 5]])
    mean, covariance = cable_mean_and_covariance(states, np.array([0.25, 0.75]))
    np.testing.assert_allclose(mean[:3], [2.5, 0.25, 21.5])
    assert covariance[0, 1] == pytest.approx(0.25 * 0.75 * 2.0 * 0.2)


@pytest.mark.parametrize("angle", [0.3, np.pi / 2, -np.pi / 2, 3.0])
def test_a_single_particle_is_its_own_mean_without_covariance(angle):
    state = np.array([[5.0, angle, 30.0, 0.1, 1.0, 0.1, 2.0, 0.2]])
    mean, covariance = cable_mean_and_covariance(state, np.ones(1))
    assert -np.pi / 2 < mean[1] <= np.pi / 2
    sign = 1.0 if np.cos(mean[1] - angle) > 0 else -1.0
    np.testing.assert_allclose(mean[[0, 2, 3, 4]], [5.0 * sign, 30.0, 0.1 * sign, sign])
    np.testing.assert_allclose(mean[[6, 7]], [2.0, 0.2 * sign])
    np.testing.assert_allclose(covariance, 0.0, atol=1e-20)


def test_a_mean_beyond_the_wrap_is_written_the_other_way_round_with_its_covariance():
    # Lines at 80 and 130 deg; the directions' mean is 89.6 deg, that of the angles 92.5.
    states = np.array(
        [
            [10.0, 80 * DEGREE, 30.0, 0.1, 4.0, 0.0, 2.0, 0.04],
            [-14.0, -50 * DEGREE, 30.0, -0.2, -8.0, 0.0, 2.0, -0.08],
        ]
    )
    mean, covariance = cable_mean_and_covariance(states, np.array([0.75, 0.25]))
    expected = [-11.0, -87.5 * DEGREE, 30.0, -0.125, -5.0, 0.0, 2.0, -0.05]
    np.testing.assert_allclose(mean, expected, atol=1e-9)
    share = 0.75 * 0.25
    assert covariance[0, 0] == pytest.approx(share * 4.0**2)
    assert covariance[0, 1] == pytest.approx(-share * 4.0 * 50 * DEGREE)
    assert covariance[0, 4] == pytest.approx(share * 4.0 * 4.0)


@given(st.floats(-np.pi, np.pi), st.integers(0, 2**32 - 1))
def test_how_the_lines_are_written_makes_no_difference(angle, seed):
    rng = np.random.default_rng(seed)
    states = cloud(rng, angle)
    weights = rng.dirichlet(np.ones(len(states)))
    other = rewritten(states, rng.random(len(states)) < 0.5, rng.choice([-np.pi, np.pi, 3 * np.pi]))
    mean, covariance = cable_mean_and_covariance(states, weights)
    again, covariance_again = cable_mean_and_covariance(other, weights)
    if np.cos(mean[1] - again[1]) > 0:  # Beside the wrap rounding may write the mean either way.
        np.testing.assert_allclose(again, mean, atol=1e-8)
        np.testing.assert_allclose(covariance_again, covariance, atol=1e-8)
    np.testing.assert_allclose(np.diag(covariance_again), np.diag(covariance), atol=1e-8)


@given(st.floats(-np.pi, np.pi), st.integers(0, 2**32 - 1))
def test_the_covariance_is_symmetric_positive_and_that_of_the_wrapped_line(angle, seed):
    states = cloud(np.random.default_rng(seed), angle)
    weights = np.full(len(states), 1 / len(states))
    mean, covariance = cable_mean_and_covariance(states, weights)
    np.testing.assert_array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    # Correlations change their sign with the line's way of writing: compare with the plain ones.
    plain = np.cov(states.T, bias=True)
    turned = np.cos(mean[1] - states[:, 1].mean()) < 0
    signs = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0]) if turned else np.ones(8)
    np.testing.assert_allclose(covariance, plain * np.outer(signs, signs), atol=1e-8)


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [([10, 20], 15), ([80, -80], 90), ([170, 0], -5), ([-90, -90], 90), ([45, 45, -30], 33.1030)],
)
def test_directions_of_lines_are_averaged_modulo_half_a_turn(degrees, expected):
    angles = np.array(degrees) * DEGREE
    weights = np.full(len(angles), 1 / len(angles))
    assert mean_line_angle(angles, weights) / DEGREE == pytest.approx(expected, abs=1e-4)


def test_directions_all_round_still_give_finite_numbers():
    angles = np.array([0.0, np.pi / 2])
    assert np.isfinite(mean_line_angle(angles, np.array([0.5, 0.5])))
