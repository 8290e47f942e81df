from __future__ import annotations

import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import FrameError
from cable_tracker.sequences.picture_header import read_picture_header

KINDS = {
    ".jpg": "JPEG", ".png": "PNG", ".bmp": "BMP", ".tiff": "TIFF", ".ppm": "PNM", ".pgm": "PNM",
}  # fmt: skip


def picture_file(suffix: str, width: int = 37, height: int = 23) -> bytes:
    channels = () if suffix == ".pgm" else (3,)
    return bytes(cv2.imencode(suffix, np.zeros((height, width, *channels), np.uint8))[1].tobytes())


@pytest.mark.parametrize("suffix", KINDS)
def test_kind_and_size_are_read(suffix):
    header = read_picture_header(memoryview(picture_file(suffix)))
    assert (header.kind, header.width, header.height) == (KINDS[suffix], 37, 23)


def test_comments_in_a_pnm_are_skipped():
    header = read_picture_header(memoryview(b"P5\n# camera 1\n12\n# x\n 34 255\n" + bytes(408)))
    assert (header.width, header.height) == (12, 34)


def test_big_endian_tiff_is_read():
    entries = [(256, 3, 1, 5 << 16), (257, 4, 1, 7)]
    directory = struct.pack(">H", 2) + b"".join(struct.pack(">HHII", *entry) for entry in entries)
    header = read_picture_header(memoryview(b"MM\0*" + struct.pack(">I", 8) + directory))
    assert (header.width, header.height) == (5, 7)


def test_an_end_padded_with_zeros_is_still_an_end():
    assert read_picture_header(memoryview(picture_file(".jpg") + bytes(100_000))).kind == "JPEG"


def test_the_end_of_a_thumbnail_is_not_the_end_of_the_picture():
    picture, thumbnail = picture_file(".jpg", 300, 200), picture_file(".jpg", 16, 12)
    segment = b"\xff\xe1" + struct.pack(">H", len(thumbnail) + 2) + thumbnail
    whole = picture[:2] + segment + picture[2:]
    assert read_picture_header(memoryview(whole)).width == 300
    with pytest.raises(FrameError, match="truncated"):
        read_picture_header(memoryview(whole[:-2]))


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_a_missing_end_is_named(suffix):
    with pytest.raises(FrameError, match="truncated"):
        read_picture_header(memoryview(picture_file(suffix, 300, 200)[:-3]))


def test_a_wrong_checksum_is_named():
    data = bytearray(picture_file(".png"))
    data[50] ^= 1
    with pytest.raises(FrameError, match="checksum"):
        read_picture_header(memoryview(data))


def test_no_bytes_are_no_picture():
    with pytest.raises(FrameError, match="no bytes"):
        read_picture_header(memoryview(b""))


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".bmp", ".tiff", ".ppm"])
@given(data=st.data())
def test_any_damaged_header_is_read_or_refused(suffix, data):
    content = bytearray(picture_file(suffix))
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(content)))
    try:
        header = read_picture_header(memoryview(bytes(content[:cut])))
    except FrameError as error:
        assert "\n" not in str(error)
    else:
        assert 0 < header.width * header.height <= 64_000_000
