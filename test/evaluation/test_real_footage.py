"""The tracker on a real camera above a white strip, and above the same ground without one."""

from itertools import islice
from pathlib import Path

import pytest

from cable_tracker.cable.model.estimate import CableEstimate, TrackingStatus
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.evaluation.metrics.errors import is_off, state_errors
from cable_tracker.evaluation.tracking.track_recording import initial_state_for, start_from
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.source import open_source
from cable_tracker.trackers import make_tracker

FOOTAGE = Path(__file__).resolve().parents[3] / "shared" / "data" / "strip"


def track(
    name: str, init: str, count: int, truth: str | None = None
) -> list[tuple[CableEstimate, CableState | None]]:
    if not (FOOTAGE / name).exists():
        pytest.skip(f"REAL FOOTAGE IS MISSING: {FOOTAGE} holds no {name}")
    labels = FOOTAGE / truth if truth else None
    tracker = make_tracker(TrackerParameters())
    with open_source(FOOTAGE / name, truth=labels) as source:
        start_from(tracker, initial_state_for(source, init))
        return [
            (tracker.process(decode_grey(frame.image), frame.stamp), frame.truth)
            for frame in islice(source.frames(), count)
        ]


def test_a_strip_is_followed_from_its_first_label():
    followed = track("strip.mp4", "truth", 120, "strip.txt")
    assert all(estimate.status is TrackingStatus.TRACKING for estimate, _ in followed)
    labelled = [(estimate.state, truth) for estimate, truth in followed if truth is not None]
    off = [is_off(state_errors(state, truth), truth) for state, truth in labelled]
    assert len(labelled) > 60
    # The quick turn of the first second is what the filter lags behind.
    assert sum(off) / len(off) < 0.15


def test_a_strip_is_found_from_nothing():
    statuses = [estimate.status for estimate, _ in track("strip.mp4", "random", 40)]
    assert statuses[0] is TrackingStatus.INITIALISING
    assert statuses[-1] is TrackingStatus.TRACKING


def test_no_strip_is_claimed_where_there_is_none():
    statuses = {estimate.status for estimate, _ in track("no_strip.mp4", "random", 120)}
    assert statuses == {TrackingStatus.INITIALISING}
