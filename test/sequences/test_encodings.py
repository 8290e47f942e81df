from __future__ import annotations

import subprocess
import sys
import tracemalloc
from dataclasses import replace
from itertools import product

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.errors import FrameError
from cable_tracker.sequences.encodings import (
    ENCODINGS,
    check_image,
    decode_bgr,
    decode_bgr_levels,
    decode_grey,
    raw_from_array,
)
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.pictures.picture_header import MAX_PIXELS

HEIGHT, WIDTH = 6, 8
CHANNELS = {
    "mono8": 1, "8UC1": 1, "mono16": 1, "16UC1": 1, "32FC1": 1, "bgr8": 3, "8UC3": 3, "rgb8": 3,
    "bgr16": 3, "rgb16": 3, "bgra8": 4, "8UC4": 4, "rgba8": 4, "yuv422": 2, "uyvy": 2,
    "yuv422_yuy2": 2, "yuyv": 2, **{name: 1 for name in ENCODINGS if name.startswith("bayer")},
}  # fmt: skip
LITTLE_AND_BIG = pytest.mark.parametrize("big", [False, True])


def number_type(encoding: str) -> str:
    if encoding == "32FC1":
        return "f4"
    return "u2" if "16" in encoding else "u1"


def random_numbers(encoding: str) -> np.ndarray:
    shape = (HEIGHT, WIDTH, CHANNELS[encoding])
    generator = np.random.default_rng(7)
    if encoding == "32FC1":
        return generator.random(shape, dtype=np.float32)
    limit = 65536 if "16" in encoding else 256
    return generator.integers(0, limit, shape).astype(number_type(encoding))


def packed(encoding: str, numbers: np.ndarray, *, padding: int = 0, big: bool = False) -> RawImage:
    """Lay numbers (H, W, C) out as a message would, with rubbish in the padding."""
    height, width = numbers.shape[:2]
    rows = numbers.astype(number_type(encoding) if not big else ">" + number_type(encoding))
    data = b"".join(row.tobytes() + b"\xa5" * padding for row in rows)
    step = len(data) // height
    return RawImage(encoding, height, width, step, big, memoryview(data))


def reference_grey(encoding: str, numbers: np.ndarray) -> np.ndarray:
    """Weights of ITU-R BT.601, in float, without OpenCV."""
    values = numbers.astype(np.float64)
    if "16" in encoding:
        values /= 257.0
    if encoding == "32FC1":
        values *= 255.0
    if encoding.startswith(("bgr", "8UC3", "8UC4")):
        return values[..., :3] @ [0.114, 0.587, 0.299]
    if encoding.startswith("rgb"):
        return values[..., :3] @ [0.299, 0.587, 0.114]
    return values[..., 1 if encoding in ("uyvy", "yuv422") else 0]


def test_every_encoding_of_the_design_is_known():
    assert set(CHANNELS) == set(ENCODINGS)


@pytest.mark.parametrize("encoding", [name for name in ENCODINGS if not name.startswith("bayer")])
def test_grey_is_the_weighted_sum_of_the_channels(encoding):
    numbers = random_numbers(encoding)
    for padding, big in product((0, 3, 8), (False, True)):
        grey = decode_grey(packed(encoding, numbers, padding=padding, big=big))
        assert grey.shape == (HEIGHT, WIDTH)
        assert grey.dtype == (np.uint8 if number_type(encoding) == "u1" else np.float32)
        np.testing.assert_allclose(grey, reference_grey(encoding, numbers), atol=1.01)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_padding_and_byte_order_change_no_pixel(encoding):
    numbers = random_numbers(encoding)
    plain = packed(encoding, numbers)
    for big in (False, True):
        padded = packed(encoding, numbers, padding=5, big=big)
        np.testing.assert_array_equal(decode_grey(plain), decode_grey(padded))
        np.testing.assert_array_equal(decode_bgr(plain), decode_bgr(padded))


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_colour_pictures_have_three_bytes_per_pixel(encoding):
    picture = decode_bgr(packed(encoding, random_numbers(encoding)))
    assert picture.shape == (HEIGHT, WIDTH, 3)
    assert picture.dtype == np.uint8


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_bayer_pattern_of_one_colour_gives_that_colour_back(pattern, bits):
    colours = {"r": 200, "g": 100, "b": 50}
    tile = np.array([colours[letter] for letter in pattern]).reshape(2, 2)
    mosaic = np.tile(tile, (4, 4)) * (257 if bits == 16 else 1)
    image = packed(f"bayer_{pattern}{bits}", mosaic[..., np.newaxis])
    inner = decode_bgr(image)[2:-2, 2:-2].reshape(-1, 3)
    np.testing.assert_array_equal(inner, np.tile([50, 100, 200], (len(inner), 1)))
    grey = 0.114 * 50 + 0.587 * 100 + 0.299 * 200
    np.testing.assert_allclose(decode_grey(image)[2:-2, 2:-2], grey, atol=1.01)


@pytest.mark.parametrize(
    ("encoding", "pixel"),
    [("bgr8", (1, 2, 3)), ("rgb8", (3, 2, 1)), ("bgra8", (1, 2, 3, 9)), ("rgba8", (3, 2, 1, 9))],
)
def test_colours_come_out_as_blue_green_red(encoding, pixel):
    numbers = np.broadcast_to(np.array(pixel, np.uint8), (HEIGHT, WIDTH, len(pixel)))
    assert decode_bgr(packed(encoding, numbers))[0, 0].tolist() == [1, 2, 3]


@pytest.mark.parametrize("encoding", ["uyvy", "yuyv"])
def test_neutral_yuv_is_grey(encoding):
    numbers = np.full((HEIGHT, WIDTH, 2), 128, np.uint8)
    blue, green, red = decode_bgr(packed(encoding, numbers))[0, 0].tolist()
    assert blue == green == red


@LITTLE_AND_BIG
def test_white_of_16_bits_is_255(big):
    grey = decode_grey(packed("mono16", np.full((2, 2, 1), 65535), big=big))
    assert grey.tolist() == [[255.0, 255.0], [255.0, 255.0]]


def test_byte_order_matters():
    numbers = np.full((2, 2, 1), 0x0100)
    image = packed("mono16", numbers)
    swapped = replace(image, is_bigendian=True)
    assert decode_grey(image)[0, 0] == np.float32(256 / 257)
    assert decode_grey(swapped)[0, 0] == np.float32(1 / 257)


@pytest.mark.parametrize(
    ("value", "grey"),
    [
        (0.0, 0.0), (0.5, 127.5), (1.0, 255.0), (-0.5, 0.0), (1.25, 255.0),
        (2.0, 2.0), (200.0, 200.0), (300.0, 255.0),
    ],
)  # fmt: skip
def test_float_pixels_up_to_one_are_scaled_and_above_it_taken_as_they_are(value, grey):
    assert decode_grey(packed("32FC1", np.full((2, 2, 1), value)))[0, 0] == grey


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@LITTLE_AND_BIG
def test_a_float_pixel_that_is_no_number_is_refused(value, big):
    numbers = np.zeros((4, 4, 1), np.float32)
    numbers[2, 1] = value
    with pytest.raises(FrameError, match="finite"):
        decode_grey(packed("32FC1", numbers, big=big))


@pytest.mark.parametrize("padding", [0, 4])
def test_mono8_is_not_copied(padding):
    image = packed("mono8", random_numbers("mono8"), padding=padding)
    grey = decode_grey(image)
    assert np.shares_memory(grey, np.frombuffer(image.data, np.uint8))
    assert not grey.flags.writeable


def test_data_may_begin_at_an_odd_address():
    numbers = random_numbers("bgr16")
    image = packed("bgr16", numbers)
    odd = replace(image, data=memoryview(b"x" + bytes(image.data))[1:])
    np.testing.assert_array_equal(decode_grey(odd), decode_grey(image))


def test_the_last_row_may_lack_its_padding():
    image = packed("bgr8", random_numbers("bgr8"), padding=5)
    short = replace(image, data=image.data[:-5])
    np.testing.assert_array_equal(decode_grey(short), decode_grey(image))


GOOD = packed("bgr8", random_numbers("bgr8"), padding=4)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"encoding": "jpeg"}, "unknown encoding 'jpeg'; known are mono8"),
        ({"encoding": ""}, "unknown encoding"),
        ({"width": 0}, "no pixels"),
        ({"height": 0}, "no pixels"),
        ({"step": 23}, "step 23 is too small: .* 24 bytes"),
        ({"step": 0}, "step 0 is too small"),
        ({"data": GOOD.data[:-5]}, "too short: 163 bytes instead of 168"),
        ({"data": memoryview(b"")}, "too short: 0 bytes"),
        ({"data": memoryview(bytes(GOOD.data) + b"x")}, "too long: 169 bytes instead of 168"),
        ({"width": 2**32 - 1, "height": 2**32 - 1}, f"more than the {MAX_PIXELS}"),
        ({"encoding": "yuyv", "width": 7}, "even width, not 7"),
        ({"encoding": "bayer_rggb8", "height": 2}, "too small for encoding bayer_rggb8"),
    ],
)
def test_a_wrong_field_is_named(changes, reason):
    bad = replace(GOOD, **changes)
    for check in (check_image, decode_grey, decode_bgr):
        with pytest.raises(FrameError, match=reason) as caught:
            check(bad)
        assert "\n" not in str(caught.value)


NUMBERS = st.integers(0, 2**32 - 1) | st.integers(0, 40)


@st.composite
def images(draw) -> RawImage:
    """Draw a raw image; of one in two, encoding, size, step and amount of data fit together."""
    if draw(st.booleans()):
        encoding, padding = draw(st.sampled_from(ENCODINGS)), draw(st.integers(0, 9))
        sound = packed(encoding, random_numbers(encoding), padding=padding, big=draw(st.booleans()))
        data = draw(st.binary(min_size=len(sound.data), max_size=len(sound.data)))
        return replace(sound, data=memoryview(data))
    encoding = draw(st.sampled_from([*ENCODINGS, "nonsense"]))
    height, width, step = draw(NUMBERS), draw(NUMBERS), draw(NUMBERS)
    data = memoryview(draw(st.binary(max_size=400)))
    return RawImage(encoding, height, width, step, draw(st.booleans()), data)


@given(images())
def test_any_message_is_decoded_or_refused(image):
    try:
        check_image(image)
    except FrameError:
        with pytest.raises(FrameError):
            decode_grey(image)
        return
    try:
        assert decode_grey(image).shape == (image.height, image.width)
    except FrameError as error:
        assert "finite" in str(error)


def encoded(suffix: str, size: tuple[int, int] = (40, 30)) -> bytes:
    noise = np.random.default_rng(3).integers(0, 256, (size[1], size[0], 3), dtype=np.uint8)
    return bytes(cv2.imencode(suffix, cv2.GaussianBlur(noise, (0, 0), 2))[1].tobytes())


def compressed(data: bytes) -> CompressedImage:
    return CompressedImage("jpeg", memoryview(data))


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_compressed_images_are_decoded(suffix):
    image = compressed(encoded(suffix))
    assert decode_grey(image).shape == (30, 40)
    assert decode_bgr(image).shape == (30, 40, 3)


@pytest.mark.parametrize("suffix", [".jpg", ".png"])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.3, 0.6, 0.9, 0.99])
def test_a_truncated_picture_is_refused(suffix, share):
    data = encoded(suffix)
    with pytest.raises(FrameError):
        decode_grey(compressed(data[: int(share * len(data))]))


@pytest.mark.parametrize("suffix", [".bmp", ".tiff", ".ppm"])
def test_other_kinds_of_pictures_are_refused(suffix):
    with pytest.raises(FrameError, match="must be JPEG or PNG"):
        decode_grey(compressed(encoded(suffix)))


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
@pytest.mark.parametrize("bits", [8, 16])
def test_a_compressed_mosaic_is_the_picture_that_it_is_uncompressed(pattern, bits):
    mosaic = random_numbers(f"bayer_{pattern}{bits}")[..., 0]
    raw = raw_from_array(mosaic, f"bayer_{pattern}{bits}")
    data = memoryview(cv2.imencode(".png", mosaic)[1].tobytes())
    image = CompressedImage(f"bayer_{pattern}{bits}; png compressed ", data)
    np.testing.assert_array_equal(decode_grey(image), decode_grey(raw))
    np.testing.assert_array_equal(decode_bgr(image), decode_bgr(raw))


@pytest.mark.parametrize("encoding", ["mono16", "bgr16"])
def test_a_png_of_16_bits_has_the_levels_of_the_raw_picture(encoding):
    # As of a camera of 12 bits: in 8 bits hardly a level would be left.
    numbers = np.squeeze(random_numbers(encoding)) // 256
    raw = raw_from_array(numbers, encoding)
    data = memoryview(cv2.imencode(".png", numbers)[1].tobytes())
    image = CompressedImage(f"{encoding}; png compressed {encoding}", data)
    np.testing.assert_array_equal(decode_bgr_levels(image), decode_bgr_levels(raw))
    # A library of PNG rounds the grey of colours its own way.
    np.testing.assert_allclose(decode_grey(image), decode_grey(raw), atol=1.5 / 257)


def test_a_jpeg_of_a_16_bit_mosaic_is_decoded_as_8_bit():
    grey = np.full((HEIGHT, WIDTH), 90, np.uint8)
    data = memoryview(cv2.imencode(".jpg", grey)[1].tobytes())
    image = CompressedImage("bayer_rggb16; jpeg compressed ", data)
    np.testing.assert_allclose(decode_grey(image), 90.0, atol=1.0)


def test_a_colour_picture_of_a_bayer_camera_is_not_demosaiced():
    colours = random_numbers("bgr8")
    data = memoryview(cv2.imencode(".png", colours)[1].tobytes())
    image = CompressedImage("bayer_rggb8; png compressed bgr8", data)
    np.testing.assert_array_equal(decode_bgr(image), colours)
    np.testing.assert_array_equal(decode_grey(image), decode_grey(compressed(bytes(data))))


def test_garbage_is_refused():
    with pytest.raises(FrameError, match="no picture"):
        decode_grey(compressed(np.random.default_rng(1).bytes(5000)))


def test_a_decompression_bomb_is_refused_before_it_is_decoded():
    bomb = cv2.imencode(".png", np.zeros((8001, 8001), np.uint8))[1].tobytes()
    assert len(bomb) < 200_000
    tracemalloc.start()
    with pytest.raises(FrameError, match="8001 x 8001"):
        decode_grey(compressed(bomb))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1_000_000


@given(
    suffix=st.sampled_from([".jpg", ".png"]), place=st.floats(0, 0.999), value=st.integers(0, 255)
)
def test_a_damaged_picture_is_decoded_or_refused(suffix, place, value):
    data = bytearray(encoded(suffix))
    data[int(place * len(data))] = value
    try:
        check_image(compressed(bytes(data)))
    except FrameError as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize("encoding", ["mono8", "bgr8", "mono16", "32FC1"])
def test_an_array_becomes_the_image_it_was(encoding):
    numbers = random_numbers(encoding)
    image = raw_from_array(numbers[..., 0] if numbers.shape[2] == 1 else numbers, encoding)
    np.testing.assert_array_equal(decode_grey(image), decode_grey(packed(encoding, numbers)))


def test_an_array_that_does_not_fit_the_encoding_is_refused():
    for encoding in ("bgr8", "mono16", "nonsense"):
        with pytest.raises(FrameError):
            raw_from_array(np.zeros((4, 4), np.uint8), encoding)


def test_opencv_prints_nothing_for_an_unreadable_picture(tmp_path):
    path = tmp_path / "missing.png"
    code = (
        "import sys; sys.path[:] = " + repr(sys.path) + "\n"
        "import cv2\n"
        "from cable_tracker.sequences.encodings import _silence_opencv\n"
        "_silence_opencv()\n"
        f"assert cv2.imread({str(path)!r}) is None\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stderr == ""
