from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from message_parts import FACTORY

from cable_tracker.errors import FrameError
from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.messages.serialised_images import (
    read_serialised_compressed_image,
    read_serialised_image,
)

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)


def serialised(message, kind, little=True):
    return bytes(typestore().serialize_cdr(message, kind, little_endian=little))


@given(STAMPS, TEXTS, TEXTS, st.binary(max_size=40), st.booleans(), st.booleans())
def test_an_image_is_read_as_another_implementation_wrote_it(
    stamp, frame_id, encoding, data, bigendian, little
):
    image = RawImage(encoding, 3, 70_000, len(data), bigendian, memoryview(data))
    message = make_image(FACTORY, image, make_header(FACTORY, stamp, frame_id))
    header, read = read_serialised_image(serialised(message, IMAGE, little))
    assert (header.stamp, header.frame_id) == (stamp, frame_id)
    assert (read.encoding, read.height, read.width) == (encoding, 3, 70_000)
    assert (read.step, read.is_bigendian, bytes(read.data)) == (len(data), bigendian, data)


@given(STAMPS, TEXTS, TEXTS, st.binary(max_size=40), st.booleans())
def test_a_compressed_image_is_read_too(stamp, frame_id, kind, data, little):
    image = CompressedImage(kind, memoryview(data))
    message = make_compressed_image(FACTORY, image, make_header(FACTORY, stamp, frame_id))
    header, read = read_serialised_compressed_image(serialised(message, COMPRESSED, little))
    assert (header.stamp, header.frame_id) == (stamp, frame_id)
    assert (read.format, bytes(read.data)) == (kind, data)


def test_the_pixels_are_a_view_that_cannot_be_written_to():
    image = RawImage("mono8", 1, 4, 4, False, memoryview(b"\1\2\3\4"))
    message = make_image(FACTORY, image, make_header(FACTORY, 5, "camera"))
    whole = serialised(message, IMAGE)
    data = read_serialised_image(whole)[1].data
    assert data.obj is whole
    assert data.readonly


HEADER = make_header(FACTORY, 5, "camera")
PIXELS = memoryview(bytes(range(40)))
SERIALISED = {
    read_serialised_image: serialised(
        make_image(FACTORY, RawImage("mono8", 4, 10, 10, False, PIXELS), HEADER), IMAGE
    ),
    read_serialised_compressed_image: serialised(
        make_compressed_image(FACTORY, CompressedImage("jpeg", PIXELS), HEADER), COMPRESSED
    ),
}


def assert_refused_or_read(read, data) -> None:
    """It says so, or gives no more data than it was given."""
    try:
        _, image = read(data)
    except FrameError as error:
        assert "the bytes received are no sensor_msgs/" in str(error)
    else:
        assert len(image.data) <= len(data)


@pytest.mark.parametrize("read", SERIALISED)
@given(data=st.binary(max_size=80), start=st.sampled_from([b"", b"\0\1\0\0", b"\0\0\0\0"]))
def test_random_bytes_are_refused_or_read(read, data, start):
    assert_refused_or_read(read, start + data)


@pytest.mark.parametrize("read", SERIALISED)
@given(place=st.integers(0, 199), byte=st.integers(0, 255))
def test_a_message_with_one_wrong_byte_is_refused_or_read(read, place, byte):
    damaged = bytearray(SERIALISED[read])
    damaged[place % len(damaged)] = byte
    assert_refused_or_read(read, bytes(damaged))


def test_a_length_beyond_the_end_is_refused():
    header = b"\0\1\0\0" + struct.pack("<iII", 1, 2, 2**32 - 1)
    with pytest.raises(FrameError, match=r"no sensor_msgs/Image"):
        read_serialised_image(header)
