from __future__ import annotations

import math
import time
from types import SimpleNamespace

import pytest

from cable_tracker.ros.inputs import frame_hold
from cable_tracker.ros.inputs.frame_hold import MOST_HELD, FrameHold
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
    hold = FrameHold(used.append, lambda stamp: stamp in told, used.append)
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
    hold = FrameHold(used.append, lambda stamp: False, used.append)
    old = frame(1, age=10.0)
    hold.take(old, 5.0)
    assert used == [old]


def test_a_frame_goes_on_waiting_when_the_next_one_comes() -> None:
    used: list[CameraFrame] = []
    told: list[int] = []
    hold = FrameHold(used.append, lambda stamp: stamp in told, used.append)
    frames = [frame(1), frame(2), frame(3)]
    for each in frames:
        hold.take(each, 3600.0)
    assert used == []
    told.append(frames[0].stamp)
    hold.release_if_due()
    assert used == frames[:1]
    told.append(frames[2].stamp)
    hold.release_if_due()
    assert used == frames


def test_a_frame_that_does_not_wait_sends_those_before_it_on() -> None:
    used: list[CameraFrame] = []
    hold = FrameHold(used.append, lambda stamp: False, used.append)
    frames = [frame(1), frame(2), frame(3)]
    for each, wait in zip(frames, (3600.0, 3600.0, 0.0), strict=True):
        hold.take(each, wait)
    assert used == frames


def test_no_more_than_a_few_frames_are_held() -> None:
    used: list[CameraFrame] = []
    hold = FrameHold(used.append, lambda stamp: False, used.append)
    frames = [frame(sec) for sec in range(MOST_HELD + 2)]
    for each in frames:
        hold.take(each, 3600.0)
    assert used == frames[:2]


def test_frames_that_a_tracker_has_no_time_for_give_way_to_the_newest() -> None:
    used: list[CameraFrame] = []
    passed_over: list[CameraFrame] = []
    told: list[int] = []
    hold = FrameHold(used.append, lambda stamp: stamp in told, passed_over.append)
    frames = [frame(1), frame(2), frame(3)]
    for each in frames:
        hold.take(each, 0.1)
    time.sleep(0.25)
    hold.release_if_due()
    assert passed_over == frames[:2]
    assert used == frames[2:]


def test_frames_whose_instruments_come_together_are_all_used() -> None:
    used: list[CameraFrame] = []
    told: list[int] = []
    hold = FrameHold(used.append, lambda stamp: stamp in told, lambda each: None)
    frames = [frame(1), frame(2), frame(3)]
    for each in frames:
        hold.take(each, 3600.0)
    told.append(frames[-1].stamp)
    hold.release_if_due()
    assert used == frames


def test_a_hold_is_due_when_its_most_impatient_frame_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hold = FrameHold(lambda each: None, lambda stamp: False, lambda each: None)
    assert hold.seconds_until_due() == math.inf
    first, second = frame(1), frame(2)
    hold.take(first, 3600.0)
    hold.take(second, 1800.0)
    clock = SimpleNamespace(perf_counter=lambda: second.arrival + 100.0)
    monkeypatch.setattr(frame_hold, "time", clock)
    assert hold.seconds_until_due() == pytest.approx(1700.0)
