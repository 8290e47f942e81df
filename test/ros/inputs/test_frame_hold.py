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


class Holding:
    """A hold, the stamps whose instruments have come, and what becomes of its frames."""

    def __init__(self) -> None:
        self.complete: list[int] = []
        self.used: list[CameraFrame] = []
        self.passed_over: list[CameraFrame] = []
        self.hold = FrameHold(
            self.used.append, lambda stamp: stamp in self.complete, self.passed_over.append
        )

    def take(self, frames: list[CameraFrame], wait: float) -> None:
        for each in frames:
            self.hold.take(each, wait)

    def completes(self, each: CameraFrame) -> None:
        self.complete.append(each.stamp)
        self.hold.release_if_due()


LONG = 3600.0
FRAMES = [frame(1), frame(2), frame(3)]


@pytest.fixture
def holding() -> Holding:
    return Holding()


def test_a_frame_waits_until_its_instruments_have_come(holding: Holding) -> None:
    holding.take(FRAMES[:1], LONG)
    holding.hold.release_if_due()
    assert holding.used == []
    holding.completes(FRAMES[0])
    assert holding.used == FRAMES[:1]


def test_a_frame_is_used_once(holding: Holding) -> None:
    holding.take(FRAMES[:1], LONG)
    holding.completes(FRAMES[0])
    holding.hold.release_if_due()
    assert holding.used == FRAMES[:1]


def test_a_frame_that_has_waited_long_enough_is_used(holding: Holding) -> None:
    old = frame(1, age=10.0)
    holding.take([old], 5.0)
    assert holding.used == [old]


def test_a_frame_goes_on_waiting_when_the_next_one_comes(holding: Holding) -> None:
    holding.take(FRAMES, LONG)
    assert holding.used == []


def test_a_complete_frame_releases_those_before_it_and_none_after_it(holding: Holding) -> None:
    holding.take(FRAMES, LONG)
    holding.completes(FRAMES[0])
    assert holding.used == FRAMES[:1]
    holding.completes(FRAMES[2])
    assert holding.used == FRAMES


def test_a_frame_that_does_not_wait_releases_those_before_it(holding: Holding) -> None:
    holding.take(FRAMES[:2], LONG)
    holding.take(FRAMES[2:], 0.0)
    assert holding.used == FRAMES


def test_no_more_than_a_few_frames_are_held(holding: Holding) -> None:
    frames = [frame(sec) for sec in range(MOST_HELD + 2)]
    holding.take(frames, LONG)
    assert holding.used == frames[:2]


def test_frames_that_a_tracker_has_no_time_for_give_way_to_the_newest(holding: Holding) -> None:
    frames = [frame(1), frame(2), frame(3)]
    holding.take(frames, 0.1)
    time.sleep(0.25)
    holding.hold.release_if_due()
    assert holding.passed_over == frames[:2]
    assert holding.used == frames[2:]


def test_frames_whose_instruments_come_together_are_all_used(holding: Holding) -> None:
    holding.take(FRAMES, LONG)
    holding.completes(FRAMES[-1])
    assert holding.used == FRAMES
    assert holding.passed_over == []


def test_a_hold_is_due_when_its_most_impatient_frame_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hold = Holding().hold
    assert hold.seconds_until_due() == math.inf
    first, second = frame(1), frame(2)
    hold.take(first, LONG)
    hold.take(second, LONG / 2)
    clock = SimpleNamespace(perf_counter=lambda: second.arrival + 100.0)
    monkeypatch.setattr(frame_hold, "time", clock)
    assert hold.seconds_until_due() == pytest.approx(LONG / 2 - 100.0)
