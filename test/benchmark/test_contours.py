import importlib.util

import pytest

from cable_tracker.benchmark import contours
from cable_tracker.benchmark.contours import measure_contour


@pytest.fixture(scope="module")
def timing():
    pytest.importorskip("skimage", reason="SCIKIT-IMAGE IS MISSING: contours are not compared")
    return measure_contour()


def test_ours_finds_the_ellipse(timing):
    assert timing.overlap > 0.98
    assert timing.ms > 0.0


def test_the_other_one_is_given_time_to_find_as_much_of_it(timing):
    assert timing.rival_overlap > 0.97
    assert timing.rival_iterations >= 10
    assert timing.ratio == timing.rival_ms / timing.ms


def test_without_scikit_image_there_is_only_ours(monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        contours, "find_spec", lambda name: None if name == "skimage" else real(name)
    )
    alone = measure_contour()
    assert (alone.rival_ms, alone.ratio) == (None, None)
