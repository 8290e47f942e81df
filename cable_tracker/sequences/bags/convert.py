"""Turn frames from anywhere into a bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from heapq import merge
from pathlib import Path
from typing import Literal

import numpy as np

from cable_tracker.arrays import eight_bits
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import BagWriter, MessageSink
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.encodings import decode_bgr, decode_grey, raw_from_array
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.target.model.estimate import Box, box_corners

JPEG_QUALITY = 95

_LITTLE_OF_WHITE = 255.0 / 8.0
_BRIGHT_PERCENTILE = 98.0


class ImageFormat(str, Enum):
    """Format in which the pixels are written."""

    AS_IS = "as-is"
    GREY = "grey"
    JPEG = "jpeg"


def in_format(frame: Frame, image_format: ImageFormat) -> Frame:
    """Return the frame with its pixels in another format.

    Raises
    ------
    FrameError
        The frame cannot be decoded; or, as it is, has no image at all.
    """
    if not frame.has_image:
        raise FrameError("there is no image in it")
    if image_format is ImageFormat.GREY:
        grey = eight_bits(decode_grey(frame.image))
        return replace(frame, image=raw_from_array(grey, "mono8"))
    if image_format is ImageFormat.JPEG:
        return replace(frame, image=encode_jpeg(decode_bgr(frame.image), JPEG_QUALITY))
    return frame


def _uses_little_of_many_bits(frame: Frame) -> bool:
    """Tell whether a frame has more than 8 bits, but nearly all of it is below 1/8 of white."""
    levels = decode_grey(frame.image)
    if levels.dtype == np.uint8:
        return False
    return bool(np.percentile(levels, _BRIGHT_PERCENTILE) < _LITTLE_OF_WHITE)


def write_truth(bag: MessageSink, frame: Frame) -> None:
    """Write a frame's ground truth if it has some."""
    if frame.truth is None:
        return
    factory = RosbagsMessages()
    header = make_header(factory, frame.stamp, frame.frame_id)
    topic = node_topics.GROUND_TRUTH
    truth = make_state(factory, header, frame.truth)
    bag.write(topic.global_name, topic.type_name, truth, frame.bag_time)


def write_box(bag: MessageSink, frame: Frame, box: Box | None) -> None:
    """Write the true box of a frame: four corners, or none where the target is out of view."""
    factory, topic = RosbagsMessages(), node_topics.TRUE_BOX
    header = make_header(factory, frame.stamp, frame.frame_id)
    corners = np.empty((0, 2)) if box is None else box_corners(box)
    polygon = make_polygon(factory, header, corners)
    bag.write(topic.global_name, topic.type_name, polygon, frame.bag_time)


def write_frame(bag: BagWriter, frame: Frame) -> None:
    """Write a frame's image, and its ground truth if it has some."""
    write_truth(bag, frame)
    factory = RosbagsMessages()
    header = make_header(factory, frame.stamp, frame.frame_id)
    if isinstance(frame.image, RawImage):
        topic, image = node_topics.IMAGE, make_image(factory, frame.image, header)
    else:
        topic = node_topics.COMPRESSED_IMAGE
        image = make_compressed_image(factory, frame.image, header)
    bag.write(topic.global_name, topic.type_name, image, frame.bag_time)


@dataclass(frozen=True, slots=True)
class CarriedMessage:
    """A message besides the frames that is carried along into their bag.

    Attributes
    ----------
    topic, type_name : str
        Name and type of its topic.
    message : object
        Message of `typestore`.
    bag_time : int
        Time of reception by the recorder [ns].
    """

    topic: str
    type_name: str
    message: object
    bag_time: int


@dataclass(frozen=True, slots=True)
class WrittenBag:
    """Result of writing a bag.

    Attributes
    ----------
    count : int
        Frames in the bag.
    skipped : int
        Frames left out because they could not be decoded.
    damage : RecordingError or None
        Damage at which the recording broke off; the bag holds the frames before that.
    is_coarse : bool
        Whether few of the levels are left: all frames had more than 8 bits, used less than 1/8 of
        that range, as those of a camera of 12 bits do, and were to be brought to 8 bits.
    """

    count: int
    skipped: int
    damage: RecordingError | None
    is_coarse: bool = False


def _in_order(
    frames: Iterable[Frame], carried: Iterable[CarriedMessage]
) -> Iterator[Frame | CarriedMessage]:
    """Yield both, as they are read, in the order of their times in the bag."""
    both: tuple[Iterable[Frame | CarriedMessage], ...] = (frames, carried)
    return iter(merge(*both, key=lambda each: each.bag_time))


def write_bag(
    path: Path,
    frames: Iterable[Frame],
    *,
    storage: Literal["sqlite3", "mcap"] = "mcap",
    image_format: ImageFormat = ImageFormat.AS_IS,
    skip_bad_frames: bool = False,
    overwrite: bool = False,
    carried: Iterable[CarriedMessage] = (),
    boxes: BoxTruth | None = None,
) -> WrittenBag:
    """Write frames into a bag with the topics `image` (or `image/compressed`) and `ground_truth`.

    True boxes of a target go to `ground_truth/box`, for the frames that have one.
    Carried messages are written between them, in the order of their times.

    Images that cannot be decoded can be written as they are, but not in another format: there they
    are left out with `skip_bad_frames`, as are frames without any image in all formats.

    Raises
    ------
    OutputError
        The bag cannot be written.
    FrameError
        A frame has no image, or is to change its format and cannot be decoded, and is not to be
        skipped.
    RecordingError
        There was not a single frame.
    """
    count = skipped = 0
    damage: RecordingError | None = None
    is_coarse = image_format is not ImageFormat.AS_IS
    with BagWriter(path, storage, overwrite=overwrite) as bag:
        try:
            for item in _in_order(frames, carried):
                if isinstance(item, CarriedMessage):
                    bag.write(item.topic, item.type_name, item.message, item.bag_time)
                    continue
                try:
                    converted = in_format(item, image_format)
                except FrameError as error:
                    if not skip_bad_frames:
                        raise FrameError(f"frame {item.index}: {error}") from error
                    skipped += 1
                    continue
                write_frame(bag, converted)
                if boxes is not None and boxes.knows(item):
                    write_box(bag, item, boxes.box(item))
                count += 1
                is_coarse = is_coarse and _uses_little_of_many_bits(item)
        except RecordingError as error:
            damage = error
        if not count:
            raise damage or RecordingError(f"{path}: there are no frames to write")
    return WrittenBag(count, skipped, damage, is_coarse)
