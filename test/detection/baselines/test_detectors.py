import numpy as np
import pytest

from cable_tracker.detection.baselines.detectors import DETECTORS


@pytest.mark.parametrize("name", DETECTORS)
def test_every_detector_finds_a_clear_strip(name):
    rng = np.random.default_rng(0)
    picture = rng.integers(50, 60, (240, 320)).astype(np.uint8)
    picture[:, 150:190] += 100
    best = DETECTORS[name]().detect(picture)[0].state
    assert best.distance == pytest.approx(10.0, abs=2.0)
    assert best.angle == pytest.approx(0.0, abs=0.03)
    assert best.width == pytest.approx(40.0, abs=4.0)
