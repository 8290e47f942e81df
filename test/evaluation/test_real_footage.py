"""The tracker on real pictures: above a white strip, above its ground, and of a sea bed."""

from collections.abc import Callable
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS
from cable_tracker.evaluation.errors import is_off_cable, state_errors
from cable_tracker.offline.track_cable import given_state_for
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.source import open_source
from cable_tracker.trackers import make_tracker
from cable_tracker.tracking.status import TrackingStatus


@pytest.fixture
def track(
    real_footage: Callable[..., Path],
) -> Callable[..., list[tuple[CableEstimate, CableState | None]]]:
    def tracked(name, init, count, truth=None):
        folder = real_footage("strip", name)
        tracker = make_tracker(TrackerParameters())
        with open_source(folder / name, truth=folder / truth if truth else None) as source:
            given = given_state_for(source, init, DEFAULT_LIMITS)
            if given is not None:
                tracker.initialise(given)
            return [
                (tracker.process(decode_grey(frame.image), frame.stamp), frame.truth)
                for frame in islice(source.frames(), count)
            ]

    return tracked


def test_a_strip_is_followed_from_its_first_label(track):
    followed = track("strip.mp4", "truth", 120, "strip.txt")
    assert all(estimate.status is TrackingStatus.TRACKING for estimate, _ in followed)
    labelled = [(estimate.state, truth) for estimate, truth in followed if truth is not None]
    errors = np.array([state_errors(state, truth) for state, truth in labelled])
    off = is_off_cable(errors, np.array([truth.width for _, truth in labelled]), forgiven=0.0)
    assert len(labelled) > 60
    # The quick turn of the first second is what the filter lags behind.
    assert off.mean() < 0.15


def test_a_strip_is_found_from_nothing(track):
    statuses = [estimate.status for estimate, _ in track("strip.mp4", "random", 40)]
    assert statuses[0] is TrackingStatus.INITIALISING
    assert statuses[-1] is TrackingStatus.TRACKING


@pytest.mark.parametrize("count", [60, pytest.param(120, marks=pytest.mark.slow)])
def test_no_strip_is_claimed_where_there_is_none(track, count):
    statuses = {estimate.status for estimate, _ in track("no_strip.mp4", "random", count)}
    assert statuses == {TrackingStatus.INITIALISING}


def panned(still: Image, count: int) -> list[Image]:
    """Frames of 320x240 from a still 400 px wide, as a camera sees it that sways over it."""
    turns = 0.5 - 0.5 * np.cos(np.arange(count) / 12)
    places = np.rint(turns[:, None] * (still.shape[1] - 320, still.shape[0] - 240)).astype(int)
    return [still[y : y + 240, x : x + 320] for x, y in places]


@pytest.mark.slow
def test_a_bar_of_finite_length_on_a_real_sea_bed_is_seldom_claimed(real_footage):
    claimed = []
    for path in sorted(real_footage("seabed").glob("*.jpg")):
        still = cv2.resize(
            cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), (400, 300), interpolation=cv2.INTER_AREA
        )
        tracker = make_tracker(TrackerParameters())
        claimed += [
            tracker.process(frame, 40_000_000 * (index + 1)).status is TrackingStatus.TRACKING
            for index, frame in enumerate(panned(still, 25))
        ]
    assert len(claimed) == 33 * 25
    # One still of the 33 is claimed for most of its frames.
    assert np.mean(claimed) < 0.06
