import cv2
import numpy as np
import pytest
from threadpoolctl import threadpool_info

from cable_tracker.errors import FrameError, MetricError
from cable_tracker.libraries import one_thread, refusals_as, without_ipp


def test_an_error_of_opencv_becomes_ours_with_its_words():
    with pytest.raises(FrameError, match=r"no corners: .*Assertion failed") as raised:  # noqa: SIM117
        with refusals_as(FrameError, "no corners"):
            cv2.goodFeaturesToTrack(np.zeros((4, 4, 3), np.float64), 5, 0.1, 2.0)
    assert isinstance(raised.value.__cause__, cv2.error)
    assert "\n" not in str(raised.value)
    assert len(str(raised.value)) <= 200 + len("no corners: ")


def test_an_error_of_numpy_becomes_ours():
    with pytest.raises(MetricError, match="no inverse: Singular matrix"):  # noqa: SIM117
        with refusals_as(MetricError, "no inverse"):
            np.linalg.inv(np.zeros((2, 2)))


def test_errors_of_our_own_and_of_python_pass():
    for error in (FrameError("x"), ValueError("x"), KeyError("x")):
        with pytest.raises(type(error)), refusals_as(MetricError, "y"):
            raise error


def test_opencv_uses_one_thread_inside_the_context():
    before = cv2.getNumThreads()
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == before


def test_linear_algebra_uses_one_thread_inside_the_context():
    before = [pool["num_threads"] for pool in blas_pools()]
    assert before
    with one_thread():
        assert [pool["num_threads"] for pool in blas_pools()] == [1] * len(before)
    assert [pool["num_threads"] for pool in blas_pools()] == before


def blas_pools():
    return [pool for pool in threadpool_info() if pool["user_api"] == "blas"]


def test_opencv_does_without_ipp_inside_the_context():
    before = cv2.ipp.useIPP()
    with without_ipp():
        assert not cv2.ipp.useIPP()
    assert cv2.ipp.useIPP() == before
