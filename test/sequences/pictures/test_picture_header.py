from __future__ import annotations

import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import FrameError
from cable_tracker.sequences.pictures.picture_header import read_picture_header

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


def tiff_file(order: str, *entries: tuple[int, int, int, int]) -> bytes:
    magic = b"II*\0" if order == "<" else b"MM\0*"
    directory = b"".join(struct.pack(f"{order}HHII", *entry) for entry in entries)
    count = struct.pack(f"{order}H", len(entries))
    return magic + struct.pack(f"{order}I", 8) + count + directory + bytes(4)


WIDTH, HEIGHT, GREY = (256, 4, 1, 5), (257, 4, 1, 7), (262, 4, 1, 1)


@pytest.mark.parametrize("order", ["<", ">"])
def test_tiffs_of_either_byte_order_are_read(order):
    header = read_picture_header(memoryview(tiff_file(order, WIDTH, HEIGHT, GREY)))
    assert (header.width, header.height) == (5, 7)


def test_a_tiff_with_two_sizes_is_refused():
    data = tiff_file("<", (256, 4, 1, 1_000_000), WIDTH, HEIGHT, GREY)
    with pytest.raises(FrameError, match="header of the TIFF"):
        read_picture_header(memoryview(data))


def png_of_size(width: int, height: int) -> bytes:
    data = bytearray(picture_file(".png"))
    data[16:24] = struct.pack(">II", width, height)
    data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    return bytes(data)


@pytest.mark.parametrize(("width", "height"), [(8001, 8000), (100_000, 100_000), (2**31 - 1, 1)])
def test_a_picture_of_too_many_pixels_is_refused_without_a_warning(width, height):
    with pytest.raises(FrameError, match=f"claims {width} x {height} pixels"):
        read_picture_header(memoryview(png_of_size(width, height)))


def test_the_size_is_that_of_the_pixels_as_stored_not_as_turned_by_exif():
    picture = picture_file(".jpg")
    turned = b"Exif\0\0" + tiff_file(">", (274, 3, 1, 6 << 16))
    whole = picture[:2] + b"\xff\xe1" + struct.pack(">H", len(turned) + 2) + turned + picture[2:]
    header = read_picture_header(memoryview(whole))
    assert (header.width, header.height) == (37, 23)


def test_damaged_exif_is_no_reason_to_refuse_a_picture():
    picture = picture_file(".jpg")
    broken = b"Exif\0\0MM\0*\xff\xff\xff"
    whole = picture[:2] + b"\xff\xe1" + struct.pack(">H", len(broken) + 2) + broken + picture[2:]
    assert read_picture_header(memoryview(whole)).kind == "JPEG"


def test_an_end_padded_with_zeros_is_still_an_end():
    assert read_picture_header(memoryview(picture_file(".jpg") + bytes(100_000))).kind == "JPEG"


def test_the_end_of_a_thumbnail_is_not_the_end_of_the_picture():
    picture, thumbnail = picture_file(".jpg", 300, 200), picture_file(".jpg", 16, 12)
    segment = b"\xff\xe1" + struct.pack(">H", len(thumbnail) + 2) + thumbnail
    whole = picture[:2] + segment + picture[2:]
    assert read_picture_header(memoryview(whole)).width == 300
    with pytest.raises(FrameError, match="truncated"):
        read_picture_header(memoryview(whole[:-2]))
    with pytest.raises(FrameError, match="truncated"):
        read_picture_header(memoryview(whole[:-2] + bytes(100)))


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


def test_unknown_data_is_refused_with_the_known_kinds():
    rubbish = memoryview(b"\0" + picture_file(".bmp"))
    with pytest.raises(FrameError, match="neither JPEG, PNG, BMP, TIFF nor PNM by its first bytes"):
        read_picture_header(rubbish)
    with pytest.raises(FrameError, match="neither JPEG nor PNG by its first bytes"):
        read_picture_header(rubbish, ("JPEG", "PNG"))


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
