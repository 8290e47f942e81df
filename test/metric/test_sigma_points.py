import numpy as np
import pytest

from cable_tracker.metric.sigma_points import mean_and_covariance, sigma_points

MEAN = np.array([100.0, 0.1, -3.0])
COVARIANCE = np.array([[4.0, 0.002, 0.0], [0.002, 1e-4, 0.001], [0.0, 0.001, 0.5]])


def test_the_points_have_the_mean_and_the_covariance():
    points = sigma_points(MEAN, COVARIANCE)
    assert points.shape == (6, 3)
    mean, covariance = mean_and_covariance(points)
    np.testing.assert_allclose(mean, MEAN)
    np.testing.assert_allclose(covariance, COVARIANCE, atol=1e-12)


def test_a_component_without_doubt_stays_where_it_is():
    points = sigma_points(MEAN, np.diag([1.0, 0.0, 2.0]))
    assert (points[:, 1] == 0.1).all()


def test_the_mean_of_a_square_is_exact():
    points = sigma_points(MEAN, COVARIANCE)
    assert (points[:, 2] ** 2).mean() == pytest.approx(9.0 + 0.5)
