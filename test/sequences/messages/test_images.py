from __future__ import annotations

import pytest
from message_parts import FACTORY, HEADER

from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.messages.images import (
    make_compressed_image,
    make_image,
    read_compressed_image,
    read_image,
)


@pytest.mark.parametrize("big", [False, True])
def test_images_are_kept_with_their_padding_and_byte_order(big, sent):
    image = RawImage("mono16", 2, 3, 8, big, memoryview(bytes(range(16))))
    again = read_image(sent(make_image(FACTORY, image, HEADER)))
    assert bytes(again.data) == bytes(image.data)
    assert (again.encoding, again.height, again.width, again.step) == ("mono16", 2, 3, 8)
    assert again.is_bigendian is big


def test_compressed_images_are_kept(sent):
    image = CompressedImage("png", memoryview(b"\x89PNG..."))
    again = read_compressed_image(sent(make_compressed_image(FACTORY, image, HEADER)))
    assert (again.format, bytes(again.data)) == ("png", b"\x89PNG...")
