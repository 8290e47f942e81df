"""Pictures out of the packets of a video stream that a bag holds, with the packets' own stamps.

`foxglove_msgs/CompressedVideo` and `ffmpeg_image_transport_msgs/FFMPEGPacket`: H.264, H.265, AV1
and VP9.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import av
import numpy as np
from av.error import FFmpegError

from cable_tracker.arrays import Image
from cable_tracker.sequences.bags.bag_storage import FFMPEG, FOXGLOVE
from cable_tracker.sequences.bags.rosbags_messages import add_definition
from cable_tracker.sequences.bags.stream_gaps import GapFinder, H264Gaps, NoGaps, TimeGaps
from cable_tracker.sequences.frame import DEFAULT_FRAME_ID
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import is_given, nanoseconds_of
from cable_tracker.sequences.pictures.picture_header import MAX_PIXELS

DEFINITIONS = {
    FOXGLOVE: "builtin_interfaces/Time timestamp\nstring frame_id\nuint8[] data\nstring format\n",
    FFMPEG: (
        "std_msgs/Header header\nint32 width\nint32 height\nstring encoding\nuint64 pts\n"
        "uint8 flags\nbool is_bigendian\nuint8[] data\n"
    ),
}

DECODERS = {
    "h264": "h264", "libx264": "h264", "avc": "h264",
    "h265": "hevc", "hevc": "hevc", "libx265": "hevc",
    "av1": "libdav1d", "libaom-av1": "libdav1d", "libsvtav1": "libdav1d",
    "vp9": "vp9", "libvpx-vp9": "vp9",
}  # fmt: skip
"""Decoder by what the sender calls its format."""

GAP_FINDERS: Mapping[str, Callable[[], GapFinder]] = {
    "h264": H264Gaps, "hevc": NoGaps, "libdav1d": TimeGaps, "vp9": TimeGaps,
}  # fmt: skip
"""What finds missing packets, by decoder."""

for _name, _text in DEFINITIONS.items():
    add_definition(_name, _text)


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet as it was recorded.

    Attributes
    ----------
    stamp : int
        Stamp of the picture [ns].
    frame_id : str
        Coordinate frame of the camera.
    format : str
        Codec, as named in the message.
    data : bytes
        One access unit.
    received : int
        Time of reception by the recorder [ns].
    count : int
        Number of the picture as its sender counts; 0 for all: it does not.
    """

    stamp: int
    frame_id: str
    format: str
    data: bytes
    received: int
    count: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class DecodedPicture:
    """Result of decoding one packet.

    Attributes
    ----------
    packet : Packet
        Packet that was decoded.
    picture : Image or None
        Picture, blue-green-red, uint8, shape (H, W, 3); None where it cannot be decoded.
    reason : str
        Reason why it cannot be decoded.
    """

    packet: Packet
    picture: Image | None
    reason: str = ""


def read_packet(message: Message, received: int) -> Packet:
    """Read a packet of either type."""
    if hasattr(message, "timestamp"):
        time, frame_id, coding = message.timestamp, message.frame_id, message.format
    else:
        time, frame_id = message.header.stamp, message.header.frame_id
        # "h264;bgr8;..." names what the encoder was given besides.
        coding = message.encoding
    coding = str(coding).split(";")[0].strip().lower()
    data = np.asarray(message.data, np.uint8).tobytes()
    count = int(getattr(message, "pts", 0))
    stamp = nanoseconds_of(time)
    if not is_given(stamp):
        stamp = received
    return Packet(stamp, str(frame_id) or DEFAULT_FRAME_ID, coding, data, received, count)


class StreamDecoder:
    """Decodes the packets of one stream; pictures come in the order in which they are to be shown.

    Packets before the first key frame give nothing. After one that is damaged or missing nothing
    counts until the next key frame: what a decoder conceals is no picture of the sea bed.
    """

    def __init__(self) -> None:
        self._context: av.VideoCodecContext | None = None
        self._gaps: GapFinder = NoGaps()
        self._format = ""
        self._waiting: dict[int, Packet] = {}
        self._number = 0
        self._is_sound = False
        self._faults: list[int] = []
        """Packets from which on nothing counts until a key frame that is coded after them."""

    def take(self, packet: Packet) -> Iterator[DecodedPicture]:
        """Take one packet, and yield what is decoded by now."""
        if packet.format != self._format or self._context is None:
            yield from self.end()
            name = DECODERS.get(packet.format)
            if name is None:
                known = ", ".join(sorted(set(DECODERS)))
                yield DecodedPicture(packet, None, f"{packet.format!r} is none of {known}")
                return
            self._context, self._format = _make_decoder(name), packet.format
            self._is_sound, self._gaps = False, GAP_FINDERS[name]()
        number, self._number = self._number, self._number + 1
        if self._gaps.is_after_gap(packet):
            self._faults.append(number)
        if not packet.data:
            # To a decoder it is the end of the stream.
            self._faults.append(number)
            yield DecodedPicture(packet, None, "empty packet")
            return
        unit = av.Packet(packet.data)
        unit.pts = unit.dts = number
        self._waiting[number] = packet
        try:
            yield from self._pictures(self._context.decode(unit))
        except FFmpegError as error:
            self._faults.append(number)
            self._waiting.pop(number, None)
            if DECODERS[self._format] == "libdav1d":
                # It keeps what it could not decode, and would decode nothing any more.
                self._context.flush_buffers()
            yield DecodedPicture(packet, None, f"damaged packet ({error.strerror})")

    def end(self) -> Iterator[DecodedPicture]:
        """Yield what is left; packets without a picture come last, in the order of their times."""
        if self._context is not None:
            try:
                yield from self._pictures(self._context.decode(None))
            except FFmpegError:
                self._is_sound = False
        yield from self._passed_over(self._number)
        self._context = None

    def _passed_over(self, number: int) -> Iterator[DecodedPicture]:
        """Yield packets before one, by the order of coding, that will not give a picture any more.

        All that is coded before a key frame is shown before it.
        """
        numbers = [each for each in self._waiting if each < number]
        for each in sorted(numbers, key=lambda each: self._waiting[each].stamp):
            packet = self._waiting.pop(each)
            yield DecodedPicture(packet, None, "the decoder gave no picture for it")

    def _pictures(self, frames: list[av.VideoFrame]) -> Iterator[DecodedPicture]:
        for frame in frames:
            number = -1 if frame.pts is None else int(frame.pts)
            packet = self._waiting.pop(number, None)
            if packet is None:
                continue
            if frame.key_frame:
                yield from self._passed_over(number)
                self._is_sound = True
                self._faults = [fault for fault in self._faults if fault > number]
            if frame.is_corrupt:
                self._is_sound = False
            # In the order of coding a picture may come after a fault, and be shown before it.
            if self._is_sound and not any(fault <= number for fault in self._faults):
                yield DecodedPicture(packet, frame.to_ndarray(format="bgr24"))
            else:
                yield DecodedPicture(packet, None, "no sound key frame has come before")


def _make_decoder(name: str) -> av.VideoCodecContext:
    context = av.CodecContext.create(name, "r")
    assert isinstance(context, av.VideoCodecContext)
    context.thread_count = 1
    # A few bytes can claim a picture that takes gigabytes.
    context.options = {"max_pixels": str(MAX_PIXELS)}
    return context
