"""Turn frames from anywhere into a bag."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum
from heapq import merge
from pathlib import Path

import numpy as np

from cable_tracker.arrays import Image, eight_bits
from cable_tracker.errors import FrameError, RecordingError
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.frame_messages import write_box, write_frame
from cable_tracker.sequences.bags.instrument_source import InstrumentSource
from cable_tracker.sequences.bags.instruments import TOPICS
from cable_tracker.sequences.encodings import decode_bgr_levels, decode_grey, raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.messages.static_transforms import TF_STATIC, TF_TYPE
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.tracking.level_gain import amplified, gain_below_white, level_range

JPEG_QUALITY = 95

_LITTLE_OF_WHITE = 255.0 / 8.0


class ImageFormat(str, Enum):
    """Format in which the pixels are written."""

    AS_IS = "as-is"
    GREY = "grey"
    JPEG = "jpeg"


def in_format(frame: Frame, image_format: ImageFormat, gain: float = 1.0) -> Frame:
    """Return the frame with its pixels in another format.

    Parameters
    ----------
    gain : float
        Factor of its levels before they are reduced to 8 bits; see `gain_of`.

    Raises
    ------
    FrameError
        The frame cannot be decoded; or, as it is, has no image at all.
    """
    if not frame.has_image:
        raise FrameError("there is no image in it")
    if image_format is ImageFormat.GREY:
        grey = _bytes_of(decode_grey(frame.image), gain)
        return replace(frame, image=raw_from_array(grey, "mono8"))
    if image_format is ImageFormat.JPEG:
        colour = _bytes_of(decode_bgr_levels(frame.image), gain)
        return replace(frame, image=encode_jpeg(colour, JPEG_QUALITY))
    return frame


def _bytes_of(levels: Image, gain: float) -> Image:
    """Return a picture in 8 bits; one that has been recorded in 8 bits stays as it is."""
    return levels if levels.dtype == np.uint8 else eight_bits(amplified(levels, gain))


def gain_of(frames: Iterable[Frame]) -> float:
    """Return the gain of a whole recording's levels before they are reduced to 8 bits.

    One factor for all frames, so that the brightness of one can be compared with that of the next:
    1, unless all frames have more than 8 bits and use less than 1/8 of that range, as those of a
    camera of 12 bits do. Reading ends at the first that is otherwise.

    Parameters
    ----------
    frames : iterable of Frame
        Frames of the recording, or some of them; those that cannot be decoded are passed over.
    """
    brightest = 0.0
    for frame in _until_damage(frames):
        try:
            levels = decode_grey(frame.image)
        except FrameError:
            continue
        if levels.dtype == np.uint8:
            return 1.0
        brightest = max(brightest, level_range(levels)[1])
        if brightest >= _LITTLE_OF_WHITE:
            return 1.0
    return gain_below_white(brightest) if brightest > 0.0 else 1.0


def _until_damage(frames: Iterable[Frame]) -> Iterator[Frame]:
    """Yield the frames before the one at which a recording breaks off."""
    try:
        yield from frames
    except RecordingError:
        return


@dataclass(frozen=True, slots=True)
class CarriedMessage:
    """A message that is written into a bag between the frames.

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


def carried_messages(source: InstrumentSource) -> Iterator[CarriedMessage]:
    """Yield what a converted bag holds besides pictures, on the topics of the recorded one."""
    static = (
        CarriedMessage(TF_STATIC, TF_TYPE, message, received)
        for received, message in source.static_messages()
    )
    readings = (
        CarriedMessage(
            source.found.topics[each.instrument],
            TOPICS[each.instrument].type_name,
            each.as_ros2(),
            each.received,
        )
        for each in source.messages()
    )
    return merge(static, readings, key=lambda each: each.bag_time)


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
    gain : float
        Factor of the levels of its frames; see `gain_of`.
    """

    count: int
    skipped: int
    damage: RecordingError | None
    gain: float = 1.0


def _in_order(
    frames: Iterable[Frame], carried: Iterable[CarriedMessage]
) -> Iterator[Frame | CarriedMessage]:
    """Yield both, as they are read, in the order of their times in the bag."""
    both: tuple[Iterable[Frame | CarriedMessage], ...] = (frames, carried)
    return iter(merge(*both, key=lambda each: each.bag_time))


def _write_in_format(
    bag: BagWriter,
    frame: Frame,
    image_format: ImageFormat,
    gain: float,
    *,
    boxes: BoxTruth | None,
    skip_bad_frames: bool,
) -> bool:
    """Write a frame in another format, with its true box if it has one; see `write_bag`.

    Returns
    -------
    bool
        Whether it is in the bag: False for one that cannot be decoded and is to be skipped.

    Raises
    ------
    FrameError
        It cannot be decoded, and is not to be skipped.
    """
    try:
        converted = in_format(frame, image_format, gain)
    except FrameError as error:
        if not skip_bad_frames:
            raise FrameError(f"frame {frame.index}: {error}") from error
        return False
    write_frame(bag, converted)
    if boxes is not None and boxes.knows(frame):
        write_box(bag, frame, boxes.box(frame))
    return True


def write_bag(
    path: Path,
    frames: Iterable[Frame],
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    image_format: ImageFormat = ImageFormat.AS_IS,
    level_frames: Iterable[Frame] = (),
    skip_bad_frames: bool = False,
    overwrite: bool = False,
    carried: Iterable[CarriedMessage] = (),
    boxes: BoxTruth | None = None,
    vehicle: bytes | None = None,
    keeps_beginning: bool = True,
) -> WrittenBag:
    """Write frames into a bag with the topics `image` (or `image/compressed`) and `ground_truth`.

    True boxes of a target go to `ground_truth/box`, for the frames that have one.
    Carried messages are written between them, in the order of their times. Of `vehicle` see
    `BagWriter`.

    Images that cannot be decoded can be written as they are, but not in another format: there they
    are left out with `skip_bad_frames`, as are frames without any image in all formats. Where
    their format changes, all get the gain of `level_frames`, which are read first; see `gain_of`.

    Of a recording that breaks off the frames before that are written. Without `keeps_beginning`
    nothing is: the bag may be to take the place of the recording itself.

    Raises
    ------
    OutputError
        The bag cannot be written.
    FrameError
        A frame has no image, or is to change its format and cannot be decoded, and is not to be
        skipped.
    RecordingError
        There was not a single frame, or the recording breaks off and its beginning is not kept.
    """
    count = skipped = 0
    gain = 1.0
    damage: RecordingError | None = None
    with BagWriter(path, storage, overwrite=overwrite, vehicle=vehicle) as bag:
        if image_format is not ImageFormat.AS_IS:
            gain = gain_of(level_frames)
        try:
            for item in _in_order(frames, carried):
                if isinstance(item, CarriedMessage):
                    bag.write(item.topic, item.type_name, item.message, item.bag_time)
                elif _write_in_format(
                    bag, item, image_format, gain, boxes=boxes, skip_bad_frames=skip_bad_frames
                ):
                    count += 1
                else:
                    skipped += 1
        except RecordingError as error:
            if not keeps_beginning:
                raise
            damage = error
        if not count:
            raise damage or RecordingError(f"{path}: there are no frames to write")
    return WrittenBag(count, skipped, damage, gain)
