"""Pictures, uncompressed or as a JPEG or PNG file."""

from __future__ import annotations

from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.messages.factory import Message, MessageFactory


def make_image(factory: MessageFactory, image: RawImage, header: Message) -> Message:
    """Pack uncompressed pixels as sensor_msgs/Image."""
    return factory.make(
        "sensor_msgs/msg/Image",
        header=header,
        height=image.height,
        width=image.width,
        encoding=image.encoding,
        is_bigendian=int(image.is_bigendian),
        step=image.step,
        data=factory.octets(image.data),
    )


def make_compressed_image(
    factory: MessageFactory, image: CompressedImage, header: Message
) -> Message:
    """Pack a JPEG or PNG file as sensor_msgs/CompressedImage."""
    return factory.make(
        "sensor_msgs/msg/CompressedImage",
        header=header,
        format=image.format,
        data=factory.octets(image.data),
    )


def read_image(message: Message) -> RawImage:
    """Read a sensor_msgs/Image without copying its pixels."""
    return RawImage(
        encoding=str(message.encoding),
        height=int(message.height),
        width=int(message.width),
        step=int(message.step),
        is_bigendian=bool(message.is_bigendian),
        data=memoryview(message.data).cast("B"),
    )


def read_compressed_image(message: Message) -> CompressedImage:
    """Read a sensor_msgs/CompressedImage without copying its bytes."""
    return CompressedImage(str(message.format), memoryview(message.data).cast("B"))
