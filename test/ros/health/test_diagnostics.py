from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.ros.health.diagnostics import (
    DISABLED,
    FROZEN_INPUT,
    LEVELS,
    STALE_INPUT,
    WARMING_UP,
    WINDOW,
    FrameStatistics,
    Level,
    cable_values,
    frame_values,
    make_diagnostics,
)
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.tracking.status import TrackingStatus


def test_every_status_has_a_level() -> None:
    own = {WARMING_UP, STALE_INPUT, FROZEN_INPUT, DISABLED}
    assert set(LEVELS) == {*(status.value for status in TrackingStatus), *own}


@pytest.mark.parametrize(
    ("status", "level"),
    [("TRACKING", Level.OK), ("LOST", Level.ERROR), (STALE_INPUT, Level.STALE)],
)
def test_the_level_follows_from_the_status(status: str, level: Level) -> None:
    factory = RclpyMessages()
    header = factory.make("std_msgs/msg/Header")
    message = make_diagnostics(factory, header, "/tracker", status, {"key": "value"})
    entry = message.status[0]
    assert entry.level == bytes([level])
    assert (entry.name, entry.message, entry.hardware_id) == (
        "/tracker: tracking",
        status,
        "/tracker",
    )
    assert [(pair.key, pair.value) for pair in entry.values] == [("key", "value")]


def test_the_frame_rate_counts_the_last_seconds_only() -> None:
    statistics = FrameStatistics()
    for number in range(100):
        statistics.arrivals.append(number * 0.1)
    assert statistics.frame_rate(9.9) == pytest.approx(10.0, abs=0.51)
    assert statistics.frame_rate(9.9 + 2 * WINDOW) == 0.0
    assert not statistics.arrivals


def test_figures_before_the_first_frame_are_empty_not_wrong() -> None:
    values = frame_values(FrameStatistics(), 0.0) | cable_values(None)
    for key in ("N_eff", "evidence", "presence [%]", "hypotheses", "last bad frame"):
        assert values[key] == ""
    assert values["frames tracked"] == "0"


@pytest.mark.parametrize(
    ("presence", "probabilities", "words"),
    [
        (0.984, (0.91, 0.08), ("98", "2 (91 %, 8 %)")),
        (0.0, (1.0,), ("0", "1 (100 %)")),
        (None, (), ("", "")),
    ],
)
def test_presence_and_hypotheses_are_given_in_percent(
    presence: float | None, probabilities: tuple[float, ...], words: tuple[str, str]
) -> None:
    state = CableState(1.0, 0.1, 30.0)
    estimate = CableEstimate(
        stamp=1,
        status=TrackingStatus.TRACKING,
        state=state,
        covariance=np.eye(8),
        effective_sample_size=10.0,
        evidence=2.0,
        image_size=(320, 240),
        presence=presence,
        hypotheses=tuple(Hypothesis(each, state) for each in probabilities),
    )
    values = cable_values(estimate)
    assert (values["presence [%]"], values["hypotheses"]) == words
