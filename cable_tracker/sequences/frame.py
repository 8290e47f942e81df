"""One frame of a recording, as it is passed from every kind of source."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.cable.model.state import CableState

DEFAULT_FRAME_ID = "camera"
"""Coordinate frame of images whose recording names none."""


@dataclass(frozen=True, slots=True, eq=False)
class RawImage:
    """Uncompressed pixels with the fields of a sensor_msgs/Image.

    Attributes
    ----------
    encoding : str
        Name of the pixel format, as in sensor_msgs/image_encodings.hpp.
    height, width : int
        Size of the image [px].
    step : int
        Length of one row in `data` [bytes]; rows may be padded.
    is_bigendian : bool
        Byte order of pixels wider than one byte.
    data : memoryview
        The pixels, ``height * step`` bytes.
    missing : str
        Reason why the recording gives no pixels at all; empty where it gives some.
    """

    encoding: str
    height: int
    width: int
    step: int
    is_bigendian: bool
    data: memoryview
    missing: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class CompressedImage:
    """A JPEG or PNG file with the fields of a sensor_msgs/CompressedImage.

    Attributes
    ----------
    format : str
        Format field of the message, for instance ``jpeg`` or ``rgb8; jpeg compressed bgr8``.
    data : memoryview
        The bytes of the file.
    missing : str
        Reason why the recording gives no file at all; empty where it gives one.
    """

    format: str
    data: memoryview
    missing: str = ""


def missing_image(reason: str, *, compressed: bool = False) -> RawImage | CompressedImage:
    """Return a placeholder for an image that is missing from a recording, with the reason."""
    nothing = memoryview(b"")
    return (
        CompressedImage("", nothing, missing=reason)
        if compressed
        else RawImage("", 0, 0, 0, False, nothing, missing=reason)
    )


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One frame of a recording.

    Attributes
    ----------
    index : int
        Number of the frame in the recording, from 0.
    stamp : int
        Time of the frame [ns]: the header's stamp, or index over frame rate.
    image : RawImage or CompressedImage
        The pixels as they were recorded, see `encodings.decode_grey`; or a `missing_image`.
    frame_id : str
        Coordinate frame named in the header, or `DEFAULT_FRAME_ID`.
    truth : CableState or None
        True state of the cable, if the recording is labelled.
    received : int or None
        When the frame was written into its bag [ns]; None outside bags. Other messages of the bag
        are ordered by it.
    """

    index: int
    stamp: int
    image: RawImage | CompressedImage
    frame_id: str = DEFAULT_FRAME_ID
    truth: CableState | None = None
    received: int | None = None

    @property
    def has_image(self) -> bool:
        """Whether there are any bytes of an image, be they decodable or not."""
        return bool(self.image.data.nbytes)

    @property
    def bag_time(self) -> int:
        """When it was written into its bag [ns], or its stamp: readers of bags sort by it."""
        return self.stamp if self.received is None else self.received
