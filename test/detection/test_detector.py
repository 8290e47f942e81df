"""What all detectors have in common."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.hough import HoughDetector
from cable_tracker.detection.baselines.line_segments import LineSegmentDetector
from cable_tracker.detection.baselines.segmentation import SegmentationDetector
from cable_tracker.detection.baselines.texture_detector import TextureDetector
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.errors import FrameError

DETECTORS = [HoughDetector, SegmentationDetector, LineSegmentDetector, TextureDetector]
POSES = {
    "upright": CableState(0.0, 0.0, 40.0),
    "aside": CableState(-70.0, 0.0, 30.0),
    "leaning": CableState(35.0, np.deg2rad(28.0), 36.0),
    "converging": CableState(10.0, np.deg2rad(-12.0), 44.0, np.deg2rad(4.0)),
    "diverging": CableState(-20.0, np.deg2rad(50.0), 40.0, np.deg2rad(-3.0)),
    "lying": CableState(25.0, np.deg2rad(90.0), 32.0),
    "nearly lying": CableState(-15.0, np.deg2rad(-88.0), 28.0),
    "narrow": CableState(40.0, np.deg2rad(-30.0), 16.0),
    "wide": CableState(5.0, np.deg2rad(8.0), 90.0),
}


@pytest.fixture(params=DETECTORS, ids=lambda kind: kind.__name__)
def detector(request):
    return request.param()


@pytest.mark.parametrize("pose", POSES.values(), ids=POSES.keys())
def test_the_best_detection_is_the_strip(detector, pose, draw_strip, errors):
    best = detector.detect(draw_strip(pose), None)[0]
    distance, angle, width, skew = np.abs(errors(best.state, pose))
    assert distance < 1.0
    assert angle < 0.5
    assert width < 2.0
    assert skew < 0.5


@pytest.mark.parametrize("size", [(160, 120), (640, 480), (1280, 720), (240, 320)], ids=str)
def test_the_strip_is_found_at_every_size_of_picture(detector, size, draw_strip, errors):
    scale = size[0] / 320
    pose = CableState(30.0 * scale, 0.2, 40.0 * scale, 0.03)
    best = detector.detect(draw_strip(pose, size), None)[0]
    distance, angle, width, skew = np.abs(errors(best.state, pose))
    assert max(distance, width) < 2.0 * max(scale, 1.0)
    assert max(angle, skew) < 1.0


def test_a_dark_strip_is_found_as_well(detector, draw_strip, errors):
    pose = POSES["leaning"]
    best = detector.detect(draw_strip(pose, strip=60.0, ground=170.0), None)[0]
    assert np.all(np.abs(errors(best.state, pose)) < 2.0)


def test_the_strip_is_found_under_noise(detector, draw_strip, errors):
    pose = POSES["converging"]
    noise = np.random.default_rng(1).normal(0.0, 8.0, (240, 320))
    image = np.clip(draw_strip(pose) + noise, 0, 255).astype(np.uint8)
    assert np.all(np.abs(errors(detector.detect(image, None)[0].state, pose)) < 2.0)


def test_float_pictures_give_the_same_as_whole_numbers(detector, draw_strip):
    image = draw_strip(POSES["leaning"])
    assert detector.detect(image, None) == detector.detect(image.astype(np.float32), None)


@pytest.mark.parametrize("size", [(16, 16), (320, 240), (16, 200), (3000, 16)], ids=str)
@pytest.mark.parametrize("level", [0, 1, 90, 255])
def test_no_cable_is_found_in_a_flat_picture(detector, size, level):
    assert detector.detect(np.full(size[::-1], level, np.uint8), None) == []


def test_a_gradient_of_light_is_no_cable(detector):
    slope = np.linspace(40, 200, 320)[None, :] * np.ones((240, 1))
    assert detector.detect(slope.astype(np.uint8), None) == []


def test_a_single_edge_is_no_cable(detector):
    image = np.full((240, 320), 60, np.uint8)
    image[:, 150:] = 180
    assert detector.detect(image, None) == []


@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**31),
    size=st.tuples(st.integers(16, 130), st.integers(16, 130)),
    sigma=st.sampled_from([1.0, 20.0, 300.0]),
    blur=st.booleans(),
)
@pytest.mark.parametrize("kind", DETECTORS)
def test_noise_gives_finite_cables_or_none(kind, seed, size, sigma, blur):
    values = np.random.default_rng(seed).normal(128.0, sigma, size)
    if blur:
        values = np.cumsum(values - 128.0, axis=1) + 128.0
    image = np.clip(values, 0, 255).astype(np.uint8)
    found = kind().detect(image, None)
    assert all(detection.state.is_finite() for detection in found)
    assert all(0.0 < detection.score <= 1.0 for detection in found)
    # Rounding may put an angle onto the open end.
    assert all(abs(detection.state.angle) <= np.pi / 2 for detection in found)


def test_the_best_comes_first(detector, draw_strip):
    image = np.maximum(
        draw_strip(CableState(-80.0, 0.0, 30.0)),
        draw_strip(CableState(70.0, 0.1, 40.0), strip=110.0),
    )
    scores = [detection.score for detection in detector.detect(image, None)]
    assert scores == sorted(scores, reverse=True)
    assert len(scores) >= 2


LEFT, RIGHT = CableState(-80.0, 0.0, 30.0), CableState(70.0, 0.1, 40.0)


@pytest.mark.parametrize("wanted", [LEFT, RIGHT], ids=["left", "right"])
def test_only_cables_in_the_region_are_found(detector, draw_strip, errors, wanted):
    image = np.maximum(draw_strip(LEFT), draw_strip(RIGHT))
    region = SearchRegion(wanted, distance=15.0, angle=0.2, width=15.0)
    found = detector.detect(image, region)
    assert np.all(np.abs(errors(found[0].state, wanted)) < 2.0)
    assert region.admits(np.array([each.state.to_array() for each in found])).all()


def test_a_region_works_in_reduced_pictures_and_across_the_wrap(detector, draw_strip, errors):
    pose = CableState(40.0, np.deg2rad(89.5), 120.0)
    expected = CableState(-40.0, np.deg2rad(-89.5), 120.0)
    region = SearchRegion(expected, distance=40.0, angle=0.1, width=30.0)
    best = detector.detect(draw_strip(pose, (1280, 720)), region)[0]
    assert np.all(np.abs(errors(best.state, pose)) < 4.0)


def test_a_region_without_a_cable_gives_nothing(detector, draw_strip):
    region = SearchRegion(CableState(100.0, 0.0, 30.0), distance=10.0, angle=0.1, width=10.0)
    assert detector.detect(draw_strip(CableState(-80.0, 0.0, 30.0)), region) == []


def test_the_same_picture_gives_the_same_detections(draw_strip, detector):
    image = draw_strip(POSES["leaning"])
    assert detector.detect(image, None) == type(detector)().detect(image, None)


def test_the_picture_is_left_as_it_is(detector, draw_strip):
    image = draw_strip(POSES["leaning"]).astype(np.float32)
    before = image.copy()
    detector.detect(image, None)
    np.testing.assert_array_equal(image, before)


@pytest.mark.parametrize(
    "image",
    [np.zeros((8, 8), np.uint8), np.zeros((40, 40, 3), np.uint8), np.full((40, 40), np.nan, "f4")],
    ids=["tiny", "colour", "nan"],
)
def test_an_image_that_is_not_grey_is_refused(detector, image):
    with pytest.raises(FrameError):
        detector.detect(image, None)
