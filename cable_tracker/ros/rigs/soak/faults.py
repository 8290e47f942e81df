"""Faults that a soak test does to a node: their classes, and the frames that are bad."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Collection, Mapping
from enum import Enum
from types import MappingProxyType

import numpy as np

from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences.messages.factory import Message

NARROWEST = 16
"""Shortest side of a frame of another size [px]."""

FLOAT_SIZE = (16, 12)
"""Size of a float image all of whose pixels are NaN [px]."""


class Fault(str, Enum):
    """One class of faults."""

    UNKNOWN_ENCODING = "unknown encoding"
    SHORT_DATA = "data too short"
    LONG_DATA = "data too long"
    NO_PIXELS = "no pixels"
    SMALL_STEP = "step too small"
    HUGE_SIZE = "size that no camera has"
    NAN_PIXELS = "pixels not finite"
    GARBAGE = "garbage for a picture"
    BLACK = "black frame"
    NOISE = "frame of noise"
    TINY = "frame of one pixel"
    OTHER_SIZE = "other frame size"
    NO_STAMP = "stamp zero"
    SAME_STAMP = "stamp repeated"
    NONSENSE_STAMP = "stamp at the end of time"
    CLOCK_BACK = "clock jumps back"
    CLOCK_AHEAD = "clock jumps ahead"
    INPUT_STOPS = "input stops"
    OVERLOAD = "overload"
    PARAMETERS = "parameter storm"
    PRIOR = "bad initial state"
    RESET = "reset and enable"
    VIEWER = "viewer comes and goes"
    QOS = "camera of other QoS"
    FROZEN = "tracker stopped and continued"
    TRACKER_KILLED = "tracker killed"
    REPLAY_KILLED = "replay killed"


WEIGHTS: Mapping[Fault, float] = MappingProxyType(
    {
        **dict.fromkeys(Fault, 10.0),
        Fault.INPUT_STOPS: 1.0,
        Fault.OVERLOAD: 3.0,
        Fault.PARAMETERS: 4.0,
        Fault.QOS: 2.0,
        Fault.FROZEN: 2.0,
        Fault.TRACKER_KILLED: 1.5,
        Fault.REPLAY_KILLED: 1.5,
    }
)
"""Relative frequency of each fault; those that take seconds are rare."""

REFUSED = frozenset(
    (
        Fault.UNKNOWN_ENCODING,
        Fault.SHORT_DATA,
        Fault.LONG_DATA,
        Fault.NO_PIXELS,
        Fault.SMALL_STEP,
        Fault.HUGE_SIZE,
        Fault.NAN_PIXELS,
        Fault.GARBAGE,
        Fault.TINY,
        Fault.SAME_STAMP,
    )
)
"""Frames that must be answered, and without a claim."""


def draw_fault(rng: np.random.Generator, possible: Collection[Fault]) -> Fault:
    """Draw one of some classes of faults."""
    faults = [fault for fault in WEIGHTS if fault in possible]
    weights = np.array([WEIGHTS[fault] for fault in faults])
    return faults[int(rng.choice(len(faults), p=weights / weights.sum()))]


def _changed(**fields: object) -> Callable[[Message, np.random.Generator], None]:
    def change(message: Message, _rng: np.random.Generator) -> None:
        for name, value in fields.items():
            setattr(message, name, value)

    return change


def _shorten(message: Message, rng: np.random.Generator) -> None:
    message.data = message.data[: int(rng.integers(len(message.data) - message.step))]


def _lengthen(message: Message, _rng: np.random.Generator) -> None:
    message.data = message.data + array("B", bytes(message.step))


def _no_numbers(message: Message, _rng: np.random.Generator) -> None:
    width, height = FLOAT_SIZE
    message.encoding, message.width, message.height = "32FC1", width, height
    message.step = 4 * width
    _fill(message, np.full((height, width), np.nan, np.float32).tobytes())


def _blacken(message: Message, _rng: np.random.Generator) -> None:
    _fill(message, bytes(len(message.data)))


def _scramble(message: Message, rng: np.random.Generator) -> None:
    _fill(message, rng.bytes(len(message.data)))


def _one_pixel(message: Message, _rng: np.random.Generator) -> None:
    message.width = message.height = message.step = 1
    _fill(message, b"\x80")


def _resize(message: Message, rng: np.random.Generator) -> None:
    """Cut the frame to a random size, from its beginning."""
    sizes = rng.integers(NARROWEST, (message.width, message.height))
    width, height = (int(size) for size in sizes)
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)
    step = width * (message.step // message.width)
    message.width, message.height, message.step = width, height, step
    _fill(message, rows[:height, :step].tobytes())


def _fill(message: Message, data: bytes) -> None:
    message.data = MESSAGES.octets(data)


CHANGES: Mapping[Fault, Callable[[Message, np.random.Generator], None]] = MappingProxyType(
    {
        Fault.UNKNOWN_ENCODING: _changed(encoding="mono9"),
        Fault.SHORT_DATA: _shorten,
        Fault.LONG_DATA: _lengthen,
        Fault.NO_PIXELS: _changed(width=0, height=0, step=0, data=array("B")),
        Fault.SMALL_STEP: _changed(step=1),
        Fault.HUGE_SIZE: _changed(width=2**31, height=2**31),
        Fault.NAN_PIXELS: _no_numbers,
        Fault.GARBAGE: _changed(encoding="\N{SNOWMAN}" * 50),
        Fault.BLACK: _blacken,
        Fault.NOISE: _scramble,
        Fault.TINY: _one_pixel,
        Fault.OTHER_SIZE: _resize,
    }
)
"""Functions that spoil an 8-bit sensor_msgs/Image, grey or in colour, in place."""


def _cut_off(message: Message, rng: np.random.Generator) -> None:
    message.data = message.data[: int(rng.integers(len(message.data) - 2))]


def _compressed_garbage(message: Message, rng: np.random.Generator) -> None:
    _fill(message, rng.bytes(int(rng.integers(1, 1000))))


def _damaged_jpeg(message: Message, rng: np.random.Generator) -> None:
    data = np.frombuffer(message.data, np.uint8).copy()
    data[rng.integers(2, len(data), 20)] = rng.integers(0, 256, 20)
    _fill(message, data.tobytes())


COMPRESSED_CHANGES: Mapping[Fault, Callable[[Message, np.random.Generator], None]] = (
    MappingProxyType(
        {
            Fault.SHORT_DATA: _cut_off,
            Fault.NO_PIXELS: _changed(data=array("B")),
            Fault.GARBAGE: _compressed_garbage,
            Fault.NOISE: _damaged_jpeg,
        }
    )
)
"""Functions that spoil a JPEG in a sensor_msgs/CompressedImage in place."""
