from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.sequences.pictures.encoded_pictures import (
    after_jpeg,
    encode_jpeg,
    jpeg_bytes,
    png_bytes,
)


def decoded(compressed) -> np.ndarray:
    return picture_of(compressed.data)


def picture_of(data) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


@pytest.fixture
def slope() -> np.ndarray:
    return np.tile(np.linspace(0, 255, 64).astype(np.uint8), (48, 1))


def test_a_grey_picture_comes_back_nearly_the_same(slope):
    compressed = encode_jpeg(slope)
    assert compressed.format == "jpeg"
    assert bytes(compressed.data[:2]) == b"\xff\xd8"
    assert np.abs(decoded(compressed).astype(int) - slope).max() <= 8


def test_a_colour_picture_keeps_the_order_of_its_channels():
    picture = np.full((32, 32, 3), (250, 128, 10), np.uint8)
    assert np.abs(decoded(encode_jpeg(picture)).astype(int) - picture).max() <= 8


def test_a_higher_quality_is_larger_and_nearer():
    noise = np.random.default_rng(0).integers(0, 256, (64, 64)).astype(np.uint8)
    low, high = encode_jpeg(noise, 20), encode_jpeg(noise, 95)
    assert len(high.data) > len(low.data)
    assert np.abs(decoded(high).astype(int) - noise).mean() < (
        np.abs(decoded(low).astype(int) - noise).mean()
    )


@pytest.mark.parametrize("shape", [(0, 0), (4, 4, 2), (2, 70_000)])
def test_a_picture_that_cannot_be_encoded_is_refused_in_one_line(shape):
    with pytest.raises(FrameError, match="cannot be encoded as JPEG") as caught:
        encode_jpeg(np.zeros(shape, np.uint8))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shape", [(5, 7), (5, 7, 3)])
def test_a_png_keeps_every_pixel(shape):
    picture = np.random.default_rng(0).integers(0, 256, shape).astype(np.uint8)
    assert np.array_equal(picture_of(png_bytes(picture)), picture)


def test_a_png_of_nothing_is_refused():
    with pytest.raises(FrameError, match="cannot be encoded as PNG"):
        png_bytes(np.zeros((0, 0), np.uint8))


def test_the_picture_after_jpeg_is_the_decoded_one():
    noise = np.random.default_rng(0).integers(0, 256, (64, 64)).astype(np.uint8)
    assert np.array_equal(after_jpeg(noise, 30), picture_of(jpeg_bytes(noise, 30)))
    assert not np.array_equal(after_jpeg(noise, 30), noise)
