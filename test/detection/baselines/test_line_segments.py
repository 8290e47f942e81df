from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.line_segments import LineSegmentDetector
from cable_tracker.errors import ResourceError


def test_an_opencv_without_the_detector_is_named(monkeypatch):
    monkeypatch.delattr(cv2, "createLineSegmentDetector")
    with pytest.raises(ResourceError, match=r"has no line segment detector; install 4\.5\.1"):
        LineSegmentDetector()


def test_a_detector_that_opencv_left_empty_is_named(monkeypatch):
    def refuse(*_):
        raise cv2.error("Implementation has been removed due original code license conflict")

    monkeypatch.setattr(cv2, "createLineSegmentDetector", refuse)
    with pytest.raises(ResourceError, match="has no line segment detector"):
        LineSegmentDetector()


def test_a_strip_in_the_dark_is_found(draw_strip, errors):
    pose = CableState(20.0, 0.3, 36.0)
    image = draw_strip(pose, strip=22.0, ground=10.0)
    found = LineSegmentDetector().detect(image, None)
    assert np.all(np.abs(errors(found[0].state, pose)) < 2.0)


@pytest.mark.parametrize("upright", [0.0, np.pi / 2], ids=["to the right", "upwards"])
def test_cables_are_found_without_a_shift(draw_strip, errors, upright):
    detector = LineSegmentDetector()
    poses = [
        CableState(distance, upright + angle, width)
        for distance in (-41.3, -8.6, 17.9, 50.4)
        for angle in (-0.04, 0.03)
        for width in (18.5, 31.0)
    ]
    found = [detector.detect(draw_strip(pose), None)[0].state for pose in poses]
    shifts = [errors(each, pose)[0] for each, pose in zip(found, poses, strict=True)]
    assert np.mean(shifts) == pytest.approx(0.0, abs=0.06)
