from __future__ import annotations

import cv2
import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.measure.picture.bend import STRAIGHT, Bend
from cable_tracker.cable.measure.picture.working_image import (
    PictureHistory,
    working_image_for,
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset


@pytest.mark.parametrize("size", [(64, 48), (320, 240)])
def test_a_frame_that_is_narrow_enough_is_taken_as_it_is(size):
    image = np.random.default_rng(0).integers(0, 256, size[::-1]).astype(np.uint8)
    working = plain_image(image)
    assert working.pixels.dtype == np.float32
    np.testing.assert_array_equal(working.pixels, image)
    assert (working.size, working.frame_size, working.reduction) == (size, size, 1.0)


def test_a_wide_frame_is_averaged_over_areas():
    image = np.random.default_rng(0).integers(0, 256, (480, 640)).astype(np.uint8)
    working = plain_image(image)
    assert (working.size, working.frame_size, working.reduction) == ((320, 240), (640, 480), 0.5)
    blocks = image.reshape(240, 2, 320, 2).mean(axis=(1, 3))
    assert np.abs(working.pixels - blocks).max() <= 0.5


def test_a_reduced_frame_keeps_its_origin_in_the_middle(draw_strip):
    state = CableState(60.0, 0.4, 80.0, 0.05)
    working = plain_image(draw_strip(state, (960, 720), blur=3.0))
    small = draw_strip(CableState(20.0, 0.4, 80.0 / 3, 0.05), (320, 240))
    assert np.abs(working.pixels - small.astype(float)).mean() < 0.5


@pytest.mark.parametrize("size", [(4000, 16), (16, 4000), (1000, 333)])
def test_frames_of_unusual_shape_are_reduced_too(size):
    working = plain_image(np.zeros(size[::-1], np.float32))
    assert working.frame_size == size
    assert working.size[0] == min(size[0], 320)


@pytest.mark.parametrize("height", [1080, 1081])
def test_a_large_frame_keeps_its_middle_and_nearly_its_levels(height, rng):
    rows = np.linspace(20.0, 220.0, height)[:, None]
    frame = np.clip(rows + rng.normal(0.0, 3.0, (height, 1920)), 0, 255).astype(np.uint8)
    image = plain_image(frame)
    expected = cv2.resize(
        np.float32(rows * np.ones(1920)), image.size, interpolation=cv2.INTER_AREA
    )
    difference = image.pixels - expected
    assert abs(difference.mean()) < 0.5 + 0.1
    assert difference.std() < 1.5


@pytest.mark.parametrize(
    ("parameters", "is_straightened"),
    [
        (TrackerParameters(), True),
        (TrackerParameters(looks="borders"), False),
        (preset("thesis").replaced({"looks": "network"}), False),
    ],
    ids=["network", "borders", "bootstrap filter"],
)
def test_a_picture_is_straightened_only_where_a_map_tells_when_the_bend_has_ended(
    parameters, is_straightened, draw_strip
):
    bent = PictureHistory(Bend(0.1))
    image = working_image_for(draw_strip(CableState(0.0, 0.0, 20.0)), parameters, bent)
    assert (not np.array_equal(image.pixels, image.frame)) == is_straightened
    assert (image.next_history.bend == STRAIGHT) != is_straightened


@pytest.mark.parametrize(("dtype", "is_amplified"), [(np.uint8, False), (np.float32, True)])
def test_only_a_picture_of_more_than_eight_bits_has_finer_steps_to_show(dtype, is_amplified):
    dim = np.random.default_rng(0).integers(0, 5, (240, 320)).astype(dtype)
    assert (plain_image(dim).gain > 1.0) == is_amplified
