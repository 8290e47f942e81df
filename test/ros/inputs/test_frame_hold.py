from __future__ import annotations

import time

from cable_tracker.ros.inputs.frame_hold import FrameHold
from cable_tracker.ros.inputs.image_input import CameraFrame
from cable_tracker.sequences.frame import CompressedImage
from cable_tracker.sequences.messages.serialised_images import MessageHeader


def frame(sec: int, age: float = 0.0) -> CameraFrame:
    image = CompressedImage("jpeg", memoryview(b""))
    header = MessageHeader(sec, 0, "eye")
    return CameraFrame(header.stamp, header, image, time.perf_counter() - age)


def test_a_frame_waits_until_everything_of_its_time_has_come() -> None:
    used: list[CameraFrame] = []
    told: list[int] = []
    hold = FrameHold(used.append, lambda stamp: stamp in told)
    first = frame(1)
    hold.take(first, 3600.0)
    hold.release_if_due()
    assert used == []
    told.append(first.stamp)
    hold.release_if_due()
    assert used == [first]
    hold.release_if_due()
    assert used == [first]


def test_a_frame_that_has_waited_long_enough_goes_on() -> None:
    used: list[CameraFrame] = []
    hold = FrameHold(used.append, lambda stamp: False)
    old = frame(1, age=10.0)
    hold.take(old, 5.0)
    assert used == [old]


def test_the_next_frame_sends_the_one_before_on() -> None:
    used: list[CameraFrame] = []
    hold = FrameHold(used.append, lambda stamp: False)
    first, second = frame(1), frame(2)
    hold.take(first, 3600.0)
    hold.take(second, 3600.0)
    assert used == [first]
