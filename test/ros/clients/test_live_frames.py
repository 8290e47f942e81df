from __future__ import annotations

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from cable_tracker.ros.clients import live_frames
from cable_tracker.ros.clients.live_frames import LiveFrames, LiveTargetFrames
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.node_topics import STATE


@pytest.fixture
def shown(monkeypatch):
    monkeypatch.setattr(live_frames, "PATIENCE", 0.0)
    return []


def picture(level):
    return raw_from_array(np.full((48, 64), level, np.uint8), "mono8")


def answered_after_many(shown, count):
    """Let a tracker answer the first of many pictures when all of them have come."""
    frames = LiveFrames(shown.append)
    for second in range(1, count + 1):
        frames.take_image(Header(stamp=Time(sec=second)), picture(second))
    frames.take(STATE, JointState(header=Header(stamp=Time(sec=1))))
    frames.hand_on_due_frame()
    return [each.row.stamp for each in shown]


def test_a_frame_is_shown_however_many_came_while_the_tracker_worked_on_it(shown):
    assert answered_after_many(shown, 200) == [1_000_000_000]


@pytest.mark.parametrize(("limit", "value"), [("KEPT_BYTES", 5 * 48 * 64), ("KEPT_SECONDS", 0.0)])
def test_frames_beyond_the_limits_of_memory_and_time_are_dropped(shown, monkeypatch, limit, value):
    monkeypatch.setattr(live_frames, limit, value)
    assert not answered_after_many(shown, 20)


def test_a_camera_without_stamps_shows_its_newest_picture_with_the_next_answer(shown):
    frames = LiveFrames(shown.append)
    for second in (5, 6):
        frames.take_image(Header(stamp=Time(sec=0)), picture(10 * second))
        frames.take(STATE, JointState(header=Header(stamp=Time(sec=second))))
    frames.hand_on_due_frame()
    assert [int(each.image[0, 0]) for each in shown] == [50, 60]


def test_a_picture_without_a_stamp_is_forgotten_when_stamps_come(shown):
    frames = LiveFrames(shown.append)
    frames.take_image(Header(stamp=Time(sec=0)), picture(10))
    frames.take_image(Header(stamp=Time(sec=7)), picture(70))
    frames.take(STATE, JointState(header=Header(stamp=Time(sec=6))))
    frames.take(STATE, JointState(header=Header(stamp=Time(sec=7))))
    frames.hand_on_due_frame()
    assert [int(each.image[0, 0]) for each in shown] == [70]


@pytest.mark.parametrize("kind", [LiveFrames, LiveTargetFrames])
def test_a_dim_picture_of_many_bits_is_brightened(shown, kind):
    frames = kind(shown.append)
    steps = np.linspace(70, 170, 64, dtype=np.uint16)
    frames.take_image(Header(stamp=Time(sec=1)), raw_from_array(np.tile(steps, (48, 1)), "mono16"))
    frames.take(STATE, JointState(header=Header(stamp=Time(sec=1))))
    frames.hand_on_due_frame()
    # Of 65535: in eight bits without a gain all of them are black.
    assert len(np.unique(shown[0].image)) > 16
